"""Random expressions in every function that a declaration may hold."""

import math

NAMES = {name: getattr(math, name) for name in ("sin", "cos", "tan", "exp", "log", "sqrt", "sinh", "cosh", "tanh")}
NAMES |= {"pi": math.pi, "e": math.e}
#: Arguments are kept where a function has a moderate value; not all of them, and none is cut off.
CALLS = (
    "sin({u})", "cos({u})", "tan({u}/3)", "exp({u}/2)", "exp(-{u}**2)", "log(3 + {u})", "log(1 + exp({u}))",
    "sqrt(4 + {u})", "sqrt(1 + {u}**2)", "sqrt({u}**2)", "sinh({u}/2)", "cosh({u}/2)", "tanh({u})", "log({u}**2)",
)  # fmt: skip
EXPONENTS = (
    "2",
    "3",
    "-1",
    "-2",
    "(1/2)",
    "(3/2)",
    "(-1/2)",
    "1.5",
    "(1/3)",
    "0.3",
    "(pi/3)",
    "-0.7",
    "k",
    "(-k)",
    "e",
)
JOINTS = ("{u} + {v}", "{u} - {v}", "{u}*{v}", "{u}/(k + 1)", "-{u}", "k*{u}", "{u}/(2 + {v}**2)", "({u} + 1/3)*0.37")
CONSTANTS = (
    "pi/4",
    "0.3",
    "1/3",
    "sqrt(2)",
    "log(2)",
    "sin(1)",
    "e/3",
    "2**0.5",
    "exp(-1)",
    "tanh(0.5)",
    "k",
    "cosh(k)",
)


def drawn_expression(rng, variables, depth):
    """Text of an expression whose calls are nested so deep, at most."""
    if depth == 0:
        return str(rng.choice([*variables, *variables, *variables, "t", "k", str(rng.choice(CONSTANTS))]))
    u, v = (f"({drawn_expression(rng, variables, depth - 1)})" for _ in range(2))
    kind = rng.random()
    if kind < 0.5:
        return str(rng.choice(CALLS)).format(u=u)
    if kind < 0.7:
        base = str(rng.choice([f"(1.2 + {u}**2)", f"(4 + {u})", f"({u}**2)"]))
        return f"{base}**{rng.choice(EXPONENTS)}"
    if kind < 0.78:
        return str(rng.choice(["(1.5 + {u}**2)**({v}/3)", "2**({u}/2)", "(1 + k)**({u}/4)", "e**({u}/3)"])).format(
            u=u, v=v
        )
    return str(rng.choice(JOINTS)).format(u=u, v=v)


def evaluated(code, point):
    """Value of an expression's text as Python's own floats have it, nan where it has no real one."""
    try:
        value = eval(code, {"__builtins__": {}}, {**NAMES, **point})  # noqa: S307
    except (ArithmeticError, ValueError):
        return math.nan
    return math.nan if isinstance(value, complex) else float(value)
