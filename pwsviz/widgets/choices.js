// A named group of check boxes, each with its explanation.

function render({ model, el }) {
  const group = document.createElement("fieldset")
  const name = document.createElement("legend")
  const why_not = option => model.barred[option]
  const is_checked = option => model.value.includes(option) && why_not(option) == null
  const draw = () => {
    name.textContent = model.label
    const boxes = model.options.map(option => {
      const box = Object.assign(document.createElement("input"), { type: "checkbox", value: option })
      const both = document.createElement("label")
      both.append(box, option)
      const one = Object.assign(document.createElement("span"), { title: why_not(option) ?? model.about[option] ?? "" })
      box.checked = is_checked(option)
      box.disabled = model.disabled || why_not(option) != null
      if (one.title != "") { box.setAttribute("aria-description", one.title) }
      box.addEventListener("change", () => {
        model.value = model.options.filter((other, k) =>
          why_not(other) != null ? model.value.includes(other) : boxes[k].querySelector("input").checked)
      })
      one.append(both)
      return one
    })
    group.replaceChildren(name, ...gather(boxes))
  }
  const gather = boxes => {  // each below the name of its group
    const titles = model.options.map(option => model.groups[option])
    return [...new Set(titles)].flatMap(title => {
      const members = boxes.filter((_, k) => titles[k] == title)
      if (title == null) { return members }
      const one = document.createElement("div"), heading = document.createElement("b")
      one.setAttribute("role", "group")
      one.setAttribute("aria-label", title)
      heading.textContent = title
      one.append(heading, ...members)
      return [one]
    })
  }
  const check = () => {
    for (const box of group.querySelectorAll("input")) { box.checked = is_checked(box.value) }
  }
  for (const setting of ["label", "options", "about", "groups", "disabled", "barred"]) { model.on(setting, draw) }
  model.on("value", check)
  draw()
  el.append(group)
}

export default { Choices: { render } }
