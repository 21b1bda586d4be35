"""What is special to a control: probing programs and what they write, and LinuxCNC run for real."""
