"""What each command does; ``cli`` gives them names and options."""
