"""The site of the documentation: ``sphinx-build docs site``. Pages are Markdown, the reference comes from docstrings.

Nothing on a page is loaded from elsewhere, so that the site can be read from a folder without a network.
"""

import inspect
import math
import re

from docutils import nodes
from latex2mathml.converter import convert
from sphinx import addnodes

import lmgcpy

project = "lmgcpy"
version = release = lmgcpy.__version__
copyright = "the authors of lmgcpy, MIT licence"

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.viewcode"]
exclude_patterns = ["conf.py"]

# Markdown: headings can be linked to, as `page.md#heading`. Formulas are TeX as GitHub reads it, $...$ and
# blocks "math". On the site they are MathML, made here: browsers typeset it, without a script and without a network.
myst_heading_anchors = 3
myst_enable_extensions = ["dollarmath"]
myst_dmath_double_inline = True
myst_fence_as_directive = ["math"]
html_math_renderer = "mathml"
highlight_language = "none"

# a reference that leads nowhere is a warning, unless it is to what others document or what only kernels read
nitpicky = True
OTHERS = r"(Sequence|Mapping)\[.*|(np|numpy|os|pathlib|collections\.abc|concurrent|sparse)\..*|Path|.*\.SomeBody"
KERNELS = r"solve\.(kernels\.(system|matrix_system)|sweeps\.(team|light_bodies))|compiled\.kernel"
INSIDE = rf"lmgcpy\.({KERNELS}|dynamics\.changes|experiment\.study\.stages|experiment\.campaign)\..*"
nitpick_ignore_regex = [("py:class", f"{OTHERS}|{INSIDE}")]

# reference: members in the order of the source, hints where the signature is
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_default_options = {"members": True}
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 100
add_module_names = False
toc_object_entries_show_parents = "hide"

html_theme = "furo"
html_static_path = ["_static"]
html_title = f"lmgcpy {version}"
html_copy_source = False
html_show_sphinx = False


def is_a_law(thing):
    return inspect.isclass(thing) and issubclass(thing, lmgcpy.Law) and thing is not lmgcpy.Law


def told(parameter):
    """One line about a parameter of a law."""
    bounds = {"above": "above", "minimum": "at least", "maximum": "at most"}
    limits = [
        f"{words} {parameter.bounds[name]:g}" for name, words in bounds.items() if math.isfinite(parameter.bounds[name])
    ]
    return f"* ``{parameter.name}`` [{parameter.unit}]: {'; '.join([parameter.text, ', '.join(limits)])}"


def signature_of_a_law(app, what, name, thing, options, signature, result):
    """A law is called with its declared parameters, by name."""
    if not is_a_law(thing):
        return None
    arguments = []
    for parameter in thing.parameters().values():
        try:
            ending = f"={float(parameter.default):g}"
        except TypeError:  # none is given, or it is None
            ending = "=None" if parameter.default is None else ""
        arguments.append(f"{parameter.name}{ending}")
    return f"({', '.join(['*', *arguments] if arguments else [])})", None


def parameters_of_a_law(app, what, name, thing, options, lines):
    if is_a_law(thing) and thing.parameters():
        lines += ["", f"Law ``{thing.NAME}``. Parameters:", "", *map(told, thing.parameters().values()), ""]
    elif is_a_law(thing):
        lines += ["", f"Law ``{thing.NAME}``, without parameters.", ""]


def perpendicular(app, what, name, thing, options, lines):
    """Docstrings are plain text, where the sign of complementarity has three characters."""
    lines[:] = [re.sub(r" +_\|_ +", " \N{UP TACK} ", line) for line in lines]


def mathml(tex, display):
    """A formula as MathML. Its TeX is an attribute: as an annotation a search would show it beside the formula."""
    known = re.sub(r"\\(begin|end){aligned}", r"\\\1{align*}", tex)  # the converter knows the outer name only
    formula = convert(known, display=display).replace(
        "<mi>&#x027C2;</mi>", '<mo lspace="0.5em" rspace="0.5em">&#x022A5;</mo>'
    )
    bar = "&#x0007C;</mo>"
    formula = formula.replace(f'<mo stretchy="false">{bar}', f'<mo stretchy="false" lspace="0" rspace="0">{bar}')
    formula = re.sub(r'columnalign="(\w+)"', r'style="text-align: \1"', formula)  # the attribute that browsers read
    text = tex.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    return formula.replace("<math ", f'<math alttext="{text}" ', 1)


def formula_in_the_text(translator, node):
    translator.body.append(mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def formula_by_itself(translator, node):
    translator.body.append(f'<div class="math-block">{mathml(node.astext(), "block")}</div>\n')
    raise nodes.SkipNode


def whole_pictures(app, doctree):
    """A picture is a link to itself in full size, unless it is another link: on a page it is as wide as the text, on a
    telephone less."""
    for picture in doctree.findall(nodes.image):
        if not isinstance(picture.parent, nodes.reference | addnodes.pending_xref | nodes.inline):
            picture["scale"] = 100


PROSE = (nodes.paragraph, nodes.strong, nodes.emphasis)
NUMBER = r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
UNIT = r"(?:%|°|(?:[kMGmµ]?(?:s|m|g|N|B|Pa)|cm|N/m|m/s|km/m)(?![\w/]))"
UNBROKEN = re.compile(
    rf"(?<![\w.])(?:\d{{1,3}}(?: \d{{3}})+(?!\w)|{NUMBER})(?: ± {NUMBER})?(?: {UNIT})?|\[\w{{1,2}}(?: \w{{1,2}})+\]"
)


def unbroken(app, doctree):
    """No line ends within a number, nor between it and its unit (10 000, 1e-10, 0.1 ± 0.2 %, [N s]), nor within a name.

    Words of code that are longer than a line on a telephone may be broken.
    """
    for text in [node for node in doctree.findall(nodes.Text) if isinstance(node.parent, PROSE)]:
        parts, at = [], 0
        for match in UNBROKEN.finditer(text):
            if " " in match[0] or "e-" in match[0]:
                parts += [nodes.Text(text[at : match.start()]), nodes.inline("", match[0], classes=["unbroken"])]
                at = match.end()
        if parts:
            text.parent.replace(text, [*parts, nodes.Text(text[at:])])
    for code in doctree.findall(nodes.literal):
        if max(map(len, code.astext().split()), default=0) < 36 and not isinstance(code.parent, nodes.title):
            code["classes"].append("unbroken")


def setup(app):
    app.connect("doctree-read", whole_pictures)
    app.connect("doctree-read", unbroken)
    app.add_html_math_renderer("mathml", (formula_in_the_text, None), (formula_by_itself, None))
    app.add_css_file("formulas.css")
    app.connect("autodoc-process-signature", signature_of_a_law)
    app.connect("autodoc-process-docstring", parameters_of_a_law)
    app.connect("autodoc-process-docstring", perpendicular)
