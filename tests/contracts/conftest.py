"""What ``added`` holds is read by ``test_adding`` alone, in a process of its own."""

collect_ignore = ["added"]
