"""What is said of a quantity that is conserved but for the rounding of its decimals."""

import pytest

import core


def refused(force, psi, **given):
    """What is said of a ψ of x′ = y, y′ = force."""
    with pytest.raises(ValueError, match="psi_minus") as caught:
        core.PiecewiseSystem(
            "Rounded", ("x", "y"), ("y", force), ("y", "-x"), "x", psi_minus=(psi,), x0=(1.0, 0.0), **given
        )
    return str(caught.value)


@pytest.mark.parametrize(
    ("force", "psi", "told"),
    [
        ("-x**2", "y**2/2 + 0.333333*x**3", "by 1e-06 of them: with 1/3 in place of 0.333333 it would be 0"),
        ("-x**2", "y**2/2 + 0.333*x**3", "by 0.001 of them: with 1/3 in place of 0.333 it would be 0"),
        ("-a*x**2", "y**2/2 + 0.3333333*a*x**3", "with 1/3 in place of 0.3333333 it would be 0"),
        ("-x*sqrt(x**2 + 1)", "y**2/2 + 0.33333*(x**2 + 1)**1.5", "with 1/3 in place of 0.33333 it would be 0"),
        ("-sqrt(2)*x", "y**2/2 + 0.70711*x**2", "with 0.70710678 in place of 0.70711 it would be 0"),
        ("-sqrt(2)*x", "y**2/2 + 0.7071067811865476*x**2", "with 0.7071067811865475244 in place of"),
        ("-9.80665", "y**2/2 + 9.807*x", "with 9.806650 in place of 9.807"),  # no fraction that is near by chance
        ("-x**2 - x**6", "y**2/2 + 0.3333*x**3 + 0.142857*x**7", "1/7 in place of 0.142857"),
    ],
)
def test_rounded_decimals_are_told_with_what_they_are_meant_for(force, psi, told):
    message = refused(force, psi, parameters={"a": 1.5} if "a*" in force else {})
    assert "as much as rounding of decimals makes" in message
    assert told in message
    assert "in some places only" not in message


@pytest.mark.parametrize(
    ("force", "psi"),
    [
        ("-x", "y**2 + x**2 + 1e-9*x"),
        ("-x**2", "y**2/2 + 0.333333*x**3 + 0.001*x**4"),
        ("-x", "1.001*y**2 + x**2"),
        ("-x**2", "y**2/2 + 0.125*x**3"),
        ("-x", "y**2 - x**2"),
    ],
)
def test_what_is_not_conserved_with_any_decimals_near_is_not_taken_for_rounded(force, psi):
    message = refused(force, psi)
    assert "is not conserved" in message
    assert "rounding" not in message
