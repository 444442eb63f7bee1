"""Guard between page and network.

Who may come: ``policy.py``, checked by ``host_check.py``, ``token.py`` and ``request_line.py``.
What a tab may send: messages and their fields ``messages.py``, values ``values.py``, rates
``connection.py``, files ``uploads.py``, the longest message ``guarded_server.py``. With several
workers, ``porter.py`` in the first counts all tabs, and hands them on to ``side_door.py`` in the
others.
"""
