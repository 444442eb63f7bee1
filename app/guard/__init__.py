"""What stands between the page and the network, and reads files from outside."""
