"""Files that controls write while or after probing: dumps of variables, logs of positions, print-outs of macros."""
