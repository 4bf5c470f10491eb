// A labelled text entry for a number and, where it has ends, a slider beside it that announces the number.

const STEPS = 400  // of the slider from end to end
const AGAIN = 300  // milliseconds without words after which a screen reader announces them again
let count = 0

function render({ model, el }) {
  const id = `number-${count++}`
  el.innerHTML = `<div class="number"><div class="field"><label for="${id}"></label><input type="text" id="${id}" autocomplete="off"
      spellcheck="false" aria-describedby="${id}-note ${id}-about"><span hidden id="${id}-about"></span></div>
    <p class="note" id="${id}-note" role="status"></p><input type="range" min="0" max="${STEPS}" step="1"></div>`
  const [number, label, entry, about, note, slider] = [".number", "label", "input", "span", "p", "input[type=range]"]
    .map(name => el.querySelector(name))

  let typing = false  // the entry holds what was not sent yet
  let sent = model.answered  // number of the last text that was sent
  const shown = () => model.text.replaceAll("-", "\u2212")  // the sign that the page prints; typed, both are understood
  // Whether there is nothing of its own to undo in the entry: Ctrl+Z is then the page's (see `browser.py`).
  const mark = () => entry.toggleAttribute("data-settled", !typing && model.complaint == "")
  const fill = () => {  // only with the answer to the last text: no late answer to another replaces what was typed since
    if (!typing && model.answered == sent) {
      const selected = entry.matches(":focus") && entry.selectionStart == 0 && entry.selectionEnd == entry.value.length
      entry.value = shown()
      if (selected) entry.select()  // what is typed next is to replace all of it
    }
    write()
  }
  const write = () => {
    mark()
    label.textContent = model.label
    about.textContent = entry.title = slider.title = model.description
    entry.disabled = slider.disabled = model.disabled
    entry.setAttribute("aria-invalid", model.complaint != "")
    if (note.textContent != (model.complaint || model.note)) {
      note.textContent = model.complaint || model.note
      if (typed && model.complaint) note.scrollIntoView({ block: "nearest" })
    }
    note.setAttribute("aria-label", `${model.label}, as read`)
    note.className = model.complaint ? "note refused" : "note"
    slider.hidden = model.ends == null
    number.classList.toggle("slides", !slider.hidden)
    slider.setAttribute("aria-label", `${model.label}, slider`)
    slider.setAttribute("aria-valuetext", model.said)
    if (model.bounds != null) {  // the slider counts its own steps: what it stands for is told in their place
      const [low, high] = model.bounds, now = Math.min(Math.max(model.value, low), high)
      for (const [name, told] of Object.entries({ min: low, max: high, now })) slider.setAttribute(`aria-value${name}`, told)
    }
    if (model.ends != null && !sliding) {
      const [low, high] = model.ends
      slider.value = Math.round(STEPS * (model.place - low) / (high - low))
    }
    slider.style.setProperty("--part", `${100 * slider.valueAsNumber / STEPS}%`)
  }
  let typed = false  // since the page was loaded: what was refused is then said where it is seen
  const take = () => {
    typed = true
    typing = false
    mark()
    model.send_msg({ number: ++sent, text: entry.value })
    if (model.complaint) {  // the same words would not be announced again, nor sent: they go for a moment
      note.textContent = "\u00a0"
      setTimeout(write, AGAIN)
    }
  }
  let sliding = false  // the thumb is in a hand: it is not moved by what the server says of an earlier place
  const slide = () => {
    const [low, high] = model.ends
    sliding = true
    model.place = low + (high - low) * slider.valueAsNumber / STEPS
    slider.style.setProperty("--part", `${100 * slider.valueAsNumber / STEPS}%`)
  }
  const rest = () => {
    sliding = false
    write()
  }
  const leave = () => {
    typing = false
    fill()
  }
  entry.addEventListener("input", () => {
    typing = model.answered != sent || entry.value != shown()
    mark()
  })
  entry.addEventListener("change", take)
  entry.addEventListener("blur", leave)  // after "change", if there is one
  slider.addEventListener("input", slide)
  for (const name of ["change", "blur", "pointerup"]) slider.addEventListener(name, rest)
  for (const name of ["said", "description", "note", "complaint", "disabled", "ends", "place", "bounds", "value"]) {
    model.on(name, write)
  }
  for (const name of ["text", "answered"]) model.on(name, fill)
  model.on("label", leave)  // it is the field of another number now
  fill()
}

export default { NumberEntry: { render } }
