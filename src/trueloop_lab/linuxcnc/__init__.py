"""A real LinuxCNC without a machine: started headless, driven, recorded; its lathe and its part are virtual."""
