"""Laws and methods → compiled functions, in memory and on disk; processes that compile beside this one."""
