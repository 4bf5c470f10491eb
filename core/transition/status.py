"""How a run ends, with reason and advice; and the kinds of crossing."""

from __future__ import annotations

from enum import IntEnum

__all__ = ["CROSSING_KINDS", "Status"]


class Status(IntEnum):
    """How a run ended. Its `advice` says what to do about it."""

    RUNNING = 0
    COMPLETED = 1
    SLIDING = 2
    REPELLING = 3
    GRAZING = 4
    NO_CONVERGENCE = 5
    ESCAPED = 6
    ZENO = 7
    CROSSING_LIMIT = 8
    STEP_LIMIT = 9
    CANCELLED = 10
    CONTRADICTION = 11
    UNSTABLE = 12
    CORNER = 13
    UNDECLARED = 14
    EVENT = 15
    EVENT_LIMIT = 16
    SINGULAR = 17

    @property
    def reason(self) -> str:
        """Why a run stops so, in plain words."""
        return _WORDS[self][0]

    @property
    def advice(self) -> str:
        """What to do about it."""
        return _WORDS[self][1]

    @property
    def reason_while_sliding(self) -> str:
        """Why a run that slides stops so."""
        return _WHILE_SLIDING.get(self, self.reason)

    @property
    def advice_while_sliding(self) -> str:
        """What to do about it while sliding."""
        return _ADVICE_WHILE_SLIDING.get(self, self.advice)

    @property
    def advice_without_tau(self) -> str:
        """What to do about it, for a method that chooses its steps."""
        return _WITHOUT_TAU.get(self, self.advice)


_WORDS = {
    Status.RUNNING: ("still running", ""),
    Status.COMPLETED: ("reached the end time", ""),
    Status.SLIDING: (
        "both fields point to the surface, so the solution slides along it",
        'To follow it along the surface, let it slide (sliding="continue").',
    ),
    Status.REPELLING: (
        "both fields point away from the surface, so the solution does not continue uniquely",
        "Start off the surface, on the side you want.",
    ),
    Status.GRAZING: (
        "the trajectory touches the surface without a transversal crossing, as far as rounding shows",
        "Rounding would decide whether the surface is met there, so the run ends. If the exact solution touches it, no "
        "step size helps: change the initial condition or a parameter so that it clearly meets the surface or clearly "
        "misses it. If not, take a smaller step size.",
    ),
    Status.NO_CONVERGENCE: (
        "no real solution of the equations of the step was found, or g is not real there",
        "Take a smaller step size.",
    ),
    Status.ESCAPED: (
        "the numerical solution blows up",
        "If the exact solution has a pole nearby, end the run before it. Otherwise take a smaller step size.",
    ),
    Status.ZENO: (
        "crossings or jumps come ever closer and accumulate here (Zeno)",
        "These laws do not determine the motion beyond this time: to continue, for instance at rest, a further law is "
        "needed.",
    ),
    Status.CROSSING_LIMIT: ("the limit of crossings is reached", "Raise the limit (max_crossings) to continue."),
    Status.STEP_LIMIT: (
        "the limit of steps is reached",
        "Take a larger step size or an earlier end time, or raise the limit (max_steps).",
    ),
    Status.CANCELLED: ("cancelled", ""),
    Status.CONTRADICTION: (
        "the state has followed the law of one side of the surface and lies on the other",
        "This is a defect of the program, not of your input: please report the system, and discard the run.",
    ),
    Status.UNSTABLE: (
        "the step is too long for this field: the numerical solution departs from the exact one",
        "Take a smaller step size, or a method that chooses its steps (taylor).",
    ),
    Status.CORNER: (
        "several surfaces are met at the same instant",
        "Change the initial condition or a parameter slightly, so that one surface is met before the other.",
    ),
    Status.UNDECLARED: (
        "the trajectory enters a region for which no law is declared",
        "Declare the law of that region (regions), or end the run before.",
    ),
    Status.EVENT: ("an event took place that ends the run", "To go on, let the event not end it (terminal=False)."),
    Status.EVENT_LIMIT: ("the limit of events is reached", "Raise the limit (max_events) to continue."),
    Status.SINGULAR: (
        "the next step passes a place where the field has no value",
        "A solution that comes there may end there: end the run before. If the exact one stays away, take a smaller "
        "step size.",
    ),
}

_WHILE_SLIDING = {
    Status.GRAZING: "sliding ends where the rates do not tell where the solution leads: both fields turn at once, or "
    "one turns infinitely slowly, or back again",
}

_ADVICE_WHILE_SLIDING = {
    Status.GRAZING: "Change the initial condition or a parameter slightly.",
    Status.CORNER: "End the run before.",
}

_WITHOUT_TAU = {
    Status.GRAZING: "Rounding would decide whether the surface is met there, so the run ends. Change the initial "
    "condition or a parameter so that it clearly meets the surface or clearly misses it.",
    Status.NO_CONVERGENCE: "The Taylor series is not defined here, as of a square root at zero, or "
    "variables differ in size by many powers of ten: take prk8 or rk8 instead.",
    Status.ESCAPED: "The solution, or its rate, seems to have a pole there: end the run before it.",
    Status.SINGULAR: "The solution may end there: end the run before.",
    Status.STEP_LIMIT: "Take a larger tolerance or an earlier end time, or raise the limit (max_steps).",
    Status.UNSTABLE: "Take a smaller tolerance.",
}

#: Names of the kinds of crossing, in the order of the compiled codes.
CROSSING_KINDS = ("transversal", "grazing", "sliding", "repelling", "jump", "leaving", "corner")
