// Names within the frame of a plot, placed anew for a picture, whose frame has another size than that on the page.

// The same model with some properties changed; models that it refers to are shared, callbacks are left out.
const LEFT_OUT = new Set(["js_event_callbacks", "js_property_callbacks", "subscribed_events", "name", "tags"])
export const copied = (model, changes) => {
  const values = {}
  for (const property of model) {
    const { attr } = property
    if (!property.internal && !property.readonly && !property.is_unset && !LEFT_OUT.has(attr)) {
      values[attr] = property.get_value()
    }
  }
  return new model.constructor({ ...values, ...changes })
}

// Let the code that places names on the page place some in another frame.
const place = (callback, changes) => {
  const args = callback.args instanceof Map ? Object.fromEntries(callback.args) : callback.args
  return copied(callback, { args: { ...args, ...changes } }).execute(callback)
}

// The renderers of a plot, in place of those of names copies for a frame of a width and a height in pixels; `letters` is how
// names are written. A renderer of names has as a tag the code that places them.
export const with_names_placed = (renderers, ranges, frame, letters) => Promise.all(renderers.map(async renderer => {
  const callback = renderer.tags.find(tag => tag?.type == "CustomJS")
  if (callback == null) return renderer
  const labels = copied(renderer.data_source, { data: { ...renderer.data_source.data } })
  const glyph = copied(renderer.glyph, letters)
  await place(callback, { labels, glyph, ranges, size: frame })
  return copied(renderer, { data_source: labels, glyph })
}))
