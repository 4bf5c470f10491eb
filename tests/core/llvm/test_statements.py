"""Machine code of generated text, against Python itself, which runs the same text, and against numba."""

import ctypes
import linecache
import math
from fractions import Fraction

import numpy as np
import pytest
import sympy

import core
from core.codegen.functions import module_text
from core.compilation.compiled import _load
from core.compilation.texts import texts_of_modes
from core.kernels.abi import ORDER, PER_UNIT, TOLERANCE, Frame
from core.kernels.doubledouble import arithmetic, elementary
from core.kernels.stack_array import stack_array
from core.kernels.taylor_coefficients import STRIDE
from core.llvm import statements
from core.llvm.operations import Unsupported
from core.methods import METHODS

POINTER = ctypes.POINTER(ctypes.c_double)
SIZE = 40


def pointer(array):
    return array.ctypes.data_as(POINTER)


def module(body: str):
    """A module of generated text whose only function has these lines."""
    lines = "\n".join(f"    {line}" for line in body.strip("\n").splitlines())
    return _load(module_text([f"@native\ndef value(t, h, p, w, scratch):\n{lines}\n"]))


def in_python(body: str):
    """The same lines run by Python."""
    lines = "\n".join(f"    {line}" for line in body.strip("\n").splitlines())
    space = {
        "math": math,
        "stack_array": stack_array,
        "carray": lambda rows, shape: rows[: shape[0] * shape[1]].reshape(shape),
    }
    exec(f"def value(t, h, p, w, scratch):\n{lines}\n", space)  # noqa: S102 - text of our own
    return space["value"]


TEXTS = {
    "arithmetic": "w[0] = p[0]*p[1] - p[2]/(1.0 + abs(p[3])) + t*h\nreturn 3",
    "powers": "w[0], w[1], w[2] = abs(p[0])**1.7, p[1]**-2, (p[2]*p[2])**(p[3])\nw[3], w[4] = t**2, h**3\nreturn 0",
    "order of comparisons": "w[0] = max(p[0], p[1], math.nan, p[2])\nw[1] = min(math.nan, p[1])\n"
    "w[2] = 1.0 if 0.0 < p[0] < p[1] else 2.0\nreturn 1",
    "short circuits": "n = 0\nif p[0] > 0.0 and p[1] > 0.0 or not p[2] > 0.0:\n    n = 5\nreturn n",
    "loops": "total = 0.0\nfor k in range(2, 9):\n    if k == 4:\n        continue\n    if p[k] > 1.5:\n        break\n"
    "    total += p[k]*k\nelse:\n    total = -1.0\nw[0] = total\nfor weight in (0.5, 0.25, -3.0):\n"
    "    w[1] += weight*t\nfor k in range(8, 2, -2):\n    w[2] = w[2]*t + p[k]\nreturn k",
    "while": "k, q = 0, 1.0\nwhile q < 100.0 and k < 30:\n    q *= 1.0 + abs(p[k])\n    k += 1\nw[0] = q\nreturn k",
    "a variable that turns into a float": "u = 0\nfor k in range(3):\n    u = u + p[k]\nw[0] = u\nreturn 0",
    "whole numbers": "m = int(p[0]*100.0)\nw[0] = m % 7\nw[1] = (m // 4)*1.0\nw[2] = (m & 5) + (m >> 2)\nreturn m % 5",
    "remainders": "w[0], w[1] = (p[0]*10.0) % 1.0, (p[1]*10.0) % -3.0\nreturn 0",
    "rows": "c = carray(scratch, (3, 5))\nfor i in range(3):\n    for k in range(5):\n"
    "        c[i, k] = c[i, k]*p[i] + k\n"
    "w[0] = c[2, 4]\nreturn 0",
    "stack_array": "a = stack_array(6)\nfor k in range(6):\n    a[k] = p[k]*t\nq = 1.0\n"
    "for k in range(5, -1, -1):\n    q = q*a[k] + 1.0\nw[0] = q\nreturn 0",
    "exchange": "a, b = p[0], p[1]\na, b = b, a\nw[0], w[1] = w[1], w[0]\nw[2] = a - 2.0*b\nreturn 0",
    "functions": "w[0] = math.sqrt(abs(p[0])) + math.exp(p[1]) - math.log(abs(p[2]) + 1.0)\n"
    "w[1] = math.floor(p[3]*7.0)\n"
    "w[2], k = math.frexp(p[4])\nw[3] = math.ldexp(p[5], k)\nw[4] = math.sinh(p[6]) + math.tan(p[7])\n"
    "w[5] = 1.0 if math.isfinite(p[0]) else 0.0\nreturn k",
    "early return": "if p[0] < 0.0:\n    return -1\nw[0] = -p[0]\nreturn 2",
}


@pytest.mark.parametrize("what", TEXTS)
def test_text_means_what_it_means_to_python(what, draws):
    body = TEXTS[what]
    made, told = module(body).value, in_python(body)
    assert made.cache_hits in (0, 1)  # machine code of ours, not numba's
    assert type(made).__module__ == "core.llvm.native"
    for rng in draws(50):
        p, w, scratch = (rng.normal(size=SIZE) for _ in range(3))
        t, h = rng.normal(size=2)
        ours, theirs = (w.copy(), scratch.copy()), (w.copy(), scratch.copy())
        number = made.ctypes(t, h, pointer(p), *map(pointer, ours))
        assert number == told(float(t), float(h), p.tolist(), *theirs), (p, w)
        # Python has the C library work out whole powers, too: within two roundings of what is multiplied out.
        rtol = 2.0**-51 if what in ("powers", "functions") else 0.0
        np.testing.assert_allclose(ours[0], theirs[0], rtol=rtol, atol=0)
        np.testing.assert_array_equal(ours[1], theirs[1])


def test_fma_is_rounded_once(draws):
    made = module("w[0] = fma(p[0], p[1], p[2])\nreturn 0").value
    for rng in draws(50):
        p, w = rng.normal(size=3), np.zeros(1)
        p[2] = -p[0] * p[1]
        made.ctypes(0.0, 0.0, pointer(p), pointer(w), pointer(w))
        assert w[0] == float(Fraction(p[0]) * Fraction(p[1]) + Fraction(p[2]))


@pytest.mark.parametrize("name", [n for n in elementary.__all__ if n != "dd_pow"] + ["dd_div", "dd_sqrt"])
def test_jitted_functions_come_out_to_the_same_bits_as_by_numba(name, draws):
    jitted = getattr(elementary, name, None) or getattr(arithmetic, name)
    pairs = 2 if name == "dd_div" else 1
    arguments = ", ".join(f"p[{k}]" for k in range(2 * pairs))
    made = module(f"w[0], w[1] = {name}({arguments})\nreturn 0").value
    for rng in draws(200):
        p = np.ravel([(a, a * 2.0**-54 * rng.uniform(-1, 1)) for a in 10.0 ** rng.uniform(-3, 2, pairs)])
        w = np.zeros(2)
        made.ctypes(0.0, 0.0, pointer(p), pointer(w), pointer(w))
        assert tuple(w) == tuple(jitted(*p)), (name, p.tolist())


@pytest.mark.parametrize(("name", "method"), [("elliptic_curve", "dmm2"), ("pendulum", "taylor")])
def test_steps_come_out_to_the_same_bits_as_by_numba(name, method, draws):
    system = core.CATALOGUE[name]
    frame = Frame(system.dimension, 1)
    text = next(text for rows, text in texts_of_modes(system.laws, METHODS[method], False, (0, 1)) if rows == [1])
    numba_text = text.replace("@native", "@cfunc(CALL, error_model='numpy')").replace(
        "from core.llvm.native import native", "from numba import cfunc\nfrom core.kernels.abi import CALL"
    )
    ours, theirs = (_load(t).step.ctypes for t in (text, numba_text))
    p = np.array([*system.parameter_array, 0.0])
    for rng in draws(100):
        w, scratch = rng.normal(size=frame.empty().size), rng.normal(size=(40, STRIDE)) * 0.1 ** np.arange(STRIDE)
        w[frame.carry : frame.increment] *= 1e-17
        w[ORDER], w[TOLERANCE], w[PER_UNIT] = 16, 1e-12, 1.0
        ends = [w.copy(), w.copy()]
        verdicts = [
            f(0.2, 0.05, pointer(p), pointer(e), pointer(scratch)) for f, e in zip((ours, theirs), ends, strict=True)
        ]
        assert verdicts[0] == verdicts[1]
        np.testing.assert_array_equal(*ends)


@pytest.mark.parametrize(
    "body", ["import os\nreturn 0", "w[0] = [1.0][0]\nreturn 0", "w[0] = open(p)\nreturn 0", "w[p[0]] = 1.0\nreturn 0",
             "with p:\n    pass\nreturn 0", "return 1.0"]
)  # fmt: skip
def test_what_is_not_in_the_language_is_told_so(body):
    source = f"def value(t, h, p, w, scratch):\n{''.join(f'    {line}' + chr(10) for line in body.splitlines())}"
    name = f"<text {hash(body)}>"
    linecache.cache[name] = (len(source), None, source.splitlines(keepends=True), name)
    space = {}
    exec(compile(source, name, "exec"), space)  # noqa: S102 - text of our own
    with pytest.raises(Unsupported):
        statements.lowered(space["value"], "value")


@pytest.mark.parametrize(("name", "method"), [("kepler", "dmm8"), ("pendulum", "taylor"), ("rigid_body", "prk8")])
def test_steps_are_compiled_without_numba(name, method, monkeypatch):
    def refuse(*_arguments, **_options):
        raise AssertionError("numba was asked")

    monkeypatch.setattr("core.llvm.native.cfunc", refuse)
    core.compilation.compiled.compile_run.__wrapped__(core.CATALOGUE[name].laws, METHODS[method], True)


@pytest.mark.parametrize("name", ["sin", "cos", "tan", "exp", "log", "sinh", "cosh", "tanh", "sqrt"])
def test_steps_that_keep_a_function_are_compiled_without_numba(name, monkeypatch):
    def refuse(*_arguments, **_options):
        raise AssertionError("numba was asked")

    monkeypatch.setattr("core.llvm.native.cfunc", refuse)
    u = sympy.Symbol("u")
    slope = sympy.sstr(getattr(sympy, name)(2 + u).diff(u))
    psi = f"v**2/2 + {name}(2 + u)"
    system = core.PiecewiseSystem("F", ("u", "v"), ("v", f"-({slope})"), ("v", "-u"), "u", (psi,), ("v**2/2 + u**2/2",))
    core.compilation.compiled.compile_run.__wrapped__(system.laws, METHODS["dmm2"], True)
