"""Reading of files from outside in a separate process.

``reader.py`` and ``running_reader.py`` are this side, ``reader_process.py`` and ``reading.py`` the
other; ``stored_upload.py`` keeps the files that wait.
"""
