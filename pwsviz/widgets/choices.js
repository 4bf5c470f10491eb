// A named group of check boxes, each with its explanation.

function render({ model, el }) {
  const group = document.createElement("fieldset")
  const name = document.createElement("legend")
  const draw = () => {
    name.textContent = model.label
    const boxes = model.options.map(option => {
      const box = Object.assign(document.createElement("input"), { type: "checkbox", value: option })
      const both = document.createElement("label")
      both.append(box, option)
      const one = Object.assign(document.createElement("span"), { title: model.about[option] ?? "" })
      box.checked = model.value.includes(option)
      box.disabled = model.disabled
      if (one.title != "") { box.setAttribute("aria-description", one.title) }
      box.addEventListener("change", () => {
        model.value = model.options.filter((_, k) => boxes[k].querySelector("input").checked)
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
    for (const box of group.querySelectorAll("input")) { box.checked = model.value.includes(box.value) }
  }
  for (const setting of ["label", "options", "about", "groups", "disabled"]) { model.on(setting, draw) }
  model.on("value", check)
  draw()
  el.append(group)
}

export default { Choices: { render } }
