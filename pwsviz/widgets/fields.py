"""The look of entries: a framed field with its name on the frame, and what stands below it."""

FRAME = "color-mix(in srgb, var(--mui-palette-text-primary) 50%, transparent)"
"""Colour of the frame: the palest that WCAG admits for the edge of a control (3:1), on light and on dark."""

LABEL = """
position: absolute; top: 0; left: 9px; z-index: 1; padding: 0 5px; max-width: calc(100% - 18px); overflow: hidden;
text-overflow: ellipsis; white-space: nowrap; font-size: 0.75rem; line-height: 1rem;
color: var(--mui-palette-text-secondary); background: var(--mui-palette-background-default);
"""
"""Style of a name that interrupts the frame."""

FOCUS = """
border-color: var(--mui-palette-primary-main); outline: 2px solid transparent;
box-shadow: 0 0 0 1px var(--mui-palette-primary-main);
"""
"""Style of a framed field that has the focus; the outline is seen where colours are forced: shadows are not."""

_TRACK = """
height: 2px; border-radius: 1px;
background: linear-gradient(to right, var(--mui-palette-primary-main) var(--part), FRAME var(--part));
""".replace("FRAME", FRAME)

_THUMB = """
appearance: none; width: 13px; height: 13px; border: none; border-radius: 50%;
background: var(--mui-palette-primary-main);
"""

FIELD_CSS = f"""
:host {{ font-size: 0.875rem; }}
.slides {{ display: grid; grid-template-columns: minmax(0, 7.25rem) 1fr; align-items: center; }}
.slides .field input {{ padding: 0 10px; }}
.slides .field label {{ font-size: 0.875rem; }}
.slides .note {{ grid-column: 1 / -1; order: 1; margin-left: 10px; }}
.field {{ position: relative; padding-top: 0.5rem; margin-top: 1px; }}
.field label {{ {LABEL} }}
.field input {{ box-sizing: border-box; width: 100%; height: 2.5rem; padding: 0 14px; font: inherit; font-size: 1rem;
                color: var(--mui-palette-text-primary); background: none; border: 1px solid {FRAME};
                border-radius: 4px; }}
.field input:hover {{ border-color: var(--mui-palette-text-primary); }}
.field input:focus-visible {{ {FOCUS} }}
.field input[aria-invalid=true] {{ border-color: var(--mui-palette-error-main); }}
.field input:disabled {{ color: var(--mui-palette-text-disabled); border-style: dashed; cursor: default; }}
.note {{ margin: 3px 14px 4px; scroll-margin: 12px; font-size: 0.75rem; line-height: 1.4; overflow-wrap: anywhere;
         color: var(--mui-palette-text-secondary); }}
.note:empty {{ display: none; }}
.note.refused {{ color: var(--mui-palette-error-main); }}
input[type=range] {{ appearance: none; width: calc(100% - 16px); min-width: 0; height: 1.5rem;
                     margin: 0.5rem 2px 0 14px; background: none; cursor: pointer; }}
input[type=range]::-webkit-slider-runnable-track {{ {_TRACK} }}
input[type=range]::-moz-range-track {{ {_TRACK} }}
input[type=range]::-webkit-slider-thumb {{ {_THUMB} margin-top: -5.5px; }}
input[type=range]::-moz-range-thumb {{ {_THUMB} }}
input[type=range]:focus-visible {{ outline: 2px solid var(--mui-palette-primary-main); border-radius: 4px; }}
[hidden] {{ display: none !important; }}
@media (forced-colors: active) {{
  input[type=range] {{ forced-color-adjust: none; --mui-palette-primary-main: Highlight;
                       --mui-palette-text-primary: CanvasText; }}
}}
"""
"""Style sheet of a number's entry and slider; `--part` is the part of the slider before its thumb."""
