"""The viser application: a tab's panels, layers and session, and the server."""
