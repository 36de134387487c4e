"""What was once wrong and is watched since: craters, bad bodies and heads, disk, leader, README."""
