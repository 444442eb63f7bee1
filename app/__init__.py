"""The viser application: the server, and the session, panels and layers of each tab."""
