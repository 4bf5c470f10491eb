"""Where tabs go on beyond the edge of a narrow screen: a button that shows the next ones."""

from __future__ import annotations

__all__ = ["MORE_TABS", "MORE_TABS_SX", "WIDTH"]

WIDTH = 40
"""Pixels of that button, beside which a tab that is cut shows that there are more, too."""

MORE_TABS = """
const more_tabs = () => {
  const scroller = find(document, ".MuiTabs-scroller")
  if (scroller == null) { if (glances_at_tabs++ < 300) { setTimeout(more_tabs, 100) }; return }
  const root = scroller.parentElement, button = document.createElement("button")
  button.type = "button"
  button.className = "more-tabs"
  const goes_on = () => scroller.scrollWidth - scroller.clientWidth - scroller.scrollLeft > 4
  const say = () => {
    const overflows = scroller.firstElementChild.scrollWidth > root.clientWidth + 1  // beside no button
    const on = overflows && goes_on()
    root.classList.toggle("overflows", overflows)
    root.classList.toggle("goes-on", on)
    button.hidden = !overflows
    button.textContent = on ? "\u203a" : "\u2039"
    button.title = button.ariaLabel = on ? "More views" : "First views"
  }
  button.addEventListener("click", () => {
    const left = goes_on() ? scroller.scrollLeft + 0.8 * scroller.clientWidth : 0
    scroller.scrollTo({ left, behavior: matchMedia("(prefers-reduced-motion: reduce)").matches ? "auto" : "smooth" })
  })
  root.append(button)
  scroller.addEventListener("scroll", say, { passive: true })
  const watcher = new ResizeObserver(say)
  for (const part of [scroller, scroller.firstElementChild]) { watcher.observe(part) }
  say()
}
let glances_at_tabs = 0
more_tabs()
"""
"""JavaScript that adds the button; the keyboard reaches all tabs by the arrows, and this button by Tab."""

MORE_TABS_SX = {
    ".more-tabs": {
        "flex": "none", "width": f"{WIDTH}px", "minHeight": "40px", "padding": 0, "border": 0, "cursor": "pointer",
        "background": "none", "font": "700 22px/1 inherit", "fontSize": "24px",
        "color": "var(--mui-palette-primary-main)",
    },
    ".more-tabs[hidden]": {"display": "none"},
    "&.goes-on .MuiTabs-scroller, .goes-on .MuiTabs-scroller": {
        "maskImage": "linear-gradient(to left, transparent, black 24px)",
    },
}  # fmt: skip
"""Its style, and the fade of the tab beside it."""
