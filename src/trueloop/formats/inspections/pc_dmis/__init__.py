"""PC-DMIS: the text of its reports and of its edit window."""
