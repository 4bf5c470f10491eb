"""The time loop, a run in progress and when it is over, the error of ψ along it, states between its steps."""
