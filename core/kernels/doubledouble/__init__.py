"""Double-double numbers, of some 32 digits: for the levels of ψ and the residuals of ψ and g."""
