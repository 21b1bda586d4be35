"""A program written in another dialect, by its tool path: `translate.translate`.

The source is run (`source`), what it does becomes statements in no control's words (`statements`), and a writer puts
these into the words of the other control (`gcode`, `klartext`). What is lost on either side is a `Lost`.
"""
