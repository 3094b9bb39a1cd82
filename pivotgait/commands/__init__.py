"""What each command does; ``cli.py`` gives them names and options."""
