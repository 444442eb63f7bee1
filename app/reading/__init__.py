"""Reading of files from outside in a separate process.

``reader.py`` and ``running_reader.py`` are this side, ``reader_process.py`` and ``reading.py`` the
other; ``reading_places.py`` says how many files are read at once, ``stored_upload.py`` keeps those
that wait.
"""
