"""What a live page adds to viser's: a title, names for screen readers, contrast, and a layout for narrow screens.

viser has no options for these. The text goes into the head of the page as it is served.
"""

from __future__ import annotations

from html import escape

#: Widest screen on which viser shows one sheet below the picture instead of panels beside it.
NARROW = "36em"
#: An element of this class names what is on show; of the next two each is seen on one kind of screen only.
NAME, ON_NARROW, ON_WIDE = "bs-name", "bs-narrow", "bs-wide"
#: The tab that displaces the blocks, and the button that puts them back, which is pressed when the tab is left: viser
#: does not say which tab is on show.
CAPACITY, AT_REST = "Capacity", "Show the blocks at rest"

# The colours have a contrast of at least 4.5 on white (WCAG 2.2, 1.4.3). On a narrow screen the picture takes the upper
# part and the sheet the lower one, so that neither hides the other.
_STYLE = f"""
:root {{
  --mantine-color-dimmed: #5c5f66 !important;
  --mantine-color-custom-6: #0072b2 !important; --mantine-color-custom-7: #005889 !important;
}}
.mantine-Button-root:not([style*="--button-bg"]):not(:disabled) {{ color: #fff }}
.{NAME} {{ font-size: 1em; font-weight: 400; color: #5c5f66; margin: .3em 10px 0 }}
.{ON_NARROW} {{ display: none }}
:focus-visible {{ outline: 2px solid #0072b2; outline-offset: 1px }}
@media (max-width: {NARROW}) {{
  .{ON_NARROW} {{ display: block; padding-bottom: .4em }} .{ON_WIDE} {{ display: none }}
  #root {{ height: 48% !important }}
  [style*="width: 20em"] {{ width: 100% !important }}
  [style*="max-height: 60%"] {{ max-height: 52% !important; min-height: 52% !important }}
}}
"""

# Controls take the name of the label in their row, to which viser does not tie them; icons say what they do.
_SCRIPT = f"""
const name = (part, text) => {{
  if (part && !part.getAttribute("aria-label")) part.setAttribute("aria-label", text);
}};
const shell = () => {{
  const title = [...document.querySelectorAll(".{NAME}")].map(part => part.textContent).find(text => text);
  if (title && document.title !== title) document.title = title;
  for (const label of document.querySelectorAll("label[for]")) {{
    const row = label.parentElement?.parentElement?.parentElement;
    row?.querySelectorAll("[role=slider], input:not([type=hidden])").forEach(part => {{
      if (part.id !== label.htmlFor) name(part, label.textContent);
    }});
  }}
  document.querySelectorAll(".mantine-CloseButton-root").forEach(button => name(button, "Close"));
  document.querySelectorAll(".mantine-ActionIcon-root").forEach(button => name(button, "Settings of the view"));
}};
new MutationObserver(shell).observe(document, {{childList: true, subtree: true, characterData: true}});
// viser turns the camera with the arrows, also while they move a slider or choose a tab.
document.addEventListener("DOMContentLoaded", () => document.body.addEventListener("keydown", event => {{
  if (event.key.startsWith("Arrow") && event.target.closest("[role=slider], [role=tab]")) event.stopPropagation();
}}));
// A box of viser's drops all but digits and the point, and with them what they meant: 0,4 would be 4, and 1e9 be 19.
const box = target => target.matches?.("input[inputmode=decimal]") ? target : null;
const put = (part, text) => {{
  Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set.call(part, text);
  part.dispatchEvent(new Event("input", {{bubbles: true}}));
}};
const refuse = (part, why) => {{ part.setCustomValidity(why); part.reportValidity(); }};
const slider = part => part.closest(".mantine-InputWrapper-root")?.parentElement?.querySelector("[role=slider]");
document.addEventListener("beforeinput", event => {{
  const part = box(event.target), text = event.data ?? "";
  if (!part) return;
  const whole = part.selectionStart === 0 && part.selectionEnd === part.value.length;
  if (part.validationMessage && event.inputType.startsWith("insert") && !whole) {{
    event.preventDefault();  // what follows a letter belongs to a number that was not taken
    part.reportValidity();
    return;
  }}
  part.setCustomValidity("");
  if (text.length !== 1 || !/[^0-9.-]/.test(text)) return;
  event.preventDefault();
  if (text === ",") document.execCommand("insertText", false, ".");
  else refuse(part, `A number has digits and a decimal point: ${{text}} is not taken`);
}}, true);
document.addEventListener("input", event => {{
  const part = box(event.target);
  if (!part || !/[^0-9.-]/.test(part.value)) return;
  event.stopImmediatePropagation();
  const text = part.value.trim().replace(",", "."), number = Number(text);
  const plain = () => number.toLocaleString("en", {{useGrouping: false, maximumFractionDigits: 9}});
  if (text && Number.isFinite(number)) put(part, plain());
  else refuse(part, `A number has digits and a decimal point: ${{part.value}} is not taken`);
}}, true);
// An empty box changes nothing: when it is left it has the value again that is used.
document.addEventListener("focusout", event => {{
  const part = box(event.target), used = part && slider(part)?.getAttribute("aria-valuenow");
  part?.setCustomValidity("");
  if (part && used && !part.value.trim()) put(part, used);
}}, true);
const left = changes => {{
  const gone = changes.some(({{target, oldValue}}) => oldValue === "true" && target.textContent.trim() === "{CAPACITY}"
    && target.getAttribute("role") === "tab" && target.getAttribute("aria-selected") !== "true");
  if (gone) [...document.querySelectorAll("button")].find(b => b.textContent.trim() === "{AT_REST}")?.click();
}};
new MutationObserver(left).observe(
  document, {{subtree: true, attributeFilter: ["aria-selected"], attributeOldValue: true}}
);
"""


def head(title: str) -> str:
    """Return what goes into the head of a live page.

    Parameters
    ----------
    title : str
        Title of the page until the name of another scene is on show. Plain text.

    Returns
    -------
    str
        HTML.

    Examples
    --------
    >>> from blockstat.view.three_d.dress import head
    >>> head("arch & pier").startswith("<title>arch &amp; pier</title>")
    True
    """
    return f"<title>{escape(title)}</title><style>{_STYLE}</style><script>{_SCRIPT}</script>"


def named(text: str) -> str:
    """Return the heading that names what is on show, and with it the page.

    Parameters
    ----------
    text : str
        Plain text.

    Returns
    -------
    str
        HTML.
    """
    return f'<h1 class="{NAME}">{escape(text)}</h1>'
