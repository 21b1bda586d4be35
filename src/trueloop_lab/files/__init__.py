"""Files of virtual machines and mills, the job that is tried on them, and the readings that the lathe gives."""
