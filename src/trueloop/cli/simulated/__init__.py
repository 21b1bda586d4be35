"""`trueloop simulate` and `linuxcnc`: the loop on a virtual machine."""
