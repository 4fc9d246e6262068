"""Formats of measured force curves, one file for each family.

================ =================================================================
``table``        `CurveTable`, what each reader returns: segments of columns
``reader``       `read_table`, which finds the format of a file
``curve_format`` `FORMATS`, the registry of formats of one's own
``text``         tables with names of columns, NanoScope and Chiaro exports among them
``jpk_text``     text exports of JPK
``jpk_map``      maps of JPK, split into their curves
``nanoscope``    binary files of NanoScope
``uff``          text files of PyFMReader
``asylum``       waves of Asylum Research, by igor2
``instrument``   other formats of instruments, by afmformats
``archive``      zip archives of files with curves
================ =================================================================
"""
