"""Generated Python text to machine code, by way of LLVM, in a twentieth of numba's time."""
