"""Systems that the editor offers to start from."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from pwsviz.editor.draft import Draft

__all__ = ["EXAMPLES"]

EXAMPLES: Mapping[str, Draft] = MappingProxyType(
    {
        "Two springs": Draft(
            name="My oscillator",
            variables="x, y",
            f_minus="y\n-k*x",
            f_plus="y\n-x",
            g="y",
            parameters="k = 3 in [0.1, 10]",
            x0="1, 1",
        ),
        "Duffing oscillator, stiffness switched": Draft(
            name="Duffing oscillator",
            variables="x, v",
            f_minus="v\n-a*x - b_minus*x^3",
            f_plus="v\n-a*x - b_plus*x^3",
            g="x",
            psi_minus="v^2/2 + a*x^2/2 + b_minus*x^4/4",
            psi_plus="v^2/2 + a*x^2/2 + b_plus*x^4/4",
            parameters="a = 1 in [0.1, 5]\nb_minus = 0.5 in [0, 5]\nb_plus = 4 in [0, 5]",
            x0="1.2, 0",
        ),
        "Lotka–Volterra with harvest": Draft(
            name="Harvested prey",
            variables="x, y",
            f_minus="x*(a - b*y)\ny*(c*x - d)",
            f_plus="x*(a - h - b*y)\ny*(c*x - d)",
            g="y - y_max",
            psi_minus="c*x - d*log(x) + b*y - a*log(y)",
            psi_plus="c*x - d*log(x) + b*y - (a - h)*log(y)",
            parameters=(
                "a = 2 in [0.5, 5]\nb = 1 in [0.1, 5]\nc = 1 in [0.1, 5]\nd = 1 in [0.1, 5]\n"
                "h = 0.8 in [0, 2]\ny_max = 2.5 in [0.5, 5]"
            ),
            x0="0.5, 1",
        ),
        "Spinning top in three dimensions": Draft(
            name="Spinning top",
            variables="p, q, r",
            f_minus="(B - C)/A*q*r\n(C - A)/B*r*p\n(A - B)/C*p*q",
            f_plus="(B - C_plus)/A*q*r\n(C_plus - A)/B*r*p\n(A - B)/C_plus*p*q",
            g="p",
            psi_minus="(A*p^2 + B*q^2 + C*r^2)/2\n(A^2*p^2 + B^2*q^2 + C^2*r^2)/2",
            psi_plus="(A*p^2 + B*q^2 + C_plus*r^2)/2\n(A^2*p^2 + B^2*q^2 + C_plus^2*r^2)/2",
            parameters="A = 1 in [0.5, 4]\nB = 2 in [0.5, 4]\nC = 3 in [0.5, 4]\nC_plus = 3.5 in [0.5, 4]",
            x0="1, 0.5, 1",
        ),
        "Impact oscillator": Draft(
            name="Impact oscillator",
            variables="x, v",
            f_minus="v\n-x",
            f_plus="v\n-x",
            g="x + wall",
            psi_minus="(x^2 + v^2)/2",
            psi_plus="(x^2 + v^2)/2",
            parameters="wall = 0.5 in [0.1, 0.9]\nr = 0.95 in [0.1, 1]",
            x0="1, 0",
            jump="-wall\n-r*v",
        ),
        "Two springs as stops, in one field": Draft(
            name="Oscillator with stops",
            variables="x, v",
            f="v\n-x - k*max(x - 1, 0) - k*min(x + 1, 0)",
            parameters="k = 8 in [0, 50]",
            x0="0, 2",
        ),
        "Van der Pol, nothing conserved": Draft(
            name="Van der Pol oscillator",
            variables="x, v",
            f_minus="v\nmu_minus*(1 - x^2)*v - x",
            f_plus="v\nmu_plus*(1 - x^2)*v - x",
            g="x",
            parameters="mu_minus = 0.5 in [0, 3]\nmu_plus = 2 in [0, 3]",
            x0="0.5, 1",
        ),
    }
)
"""Systems to start from, by title."""
