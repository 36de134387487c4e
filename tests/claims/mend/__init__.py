"""What was once wrong and is watched since: craters and settling, bad bodies and heads, disk, leader, README."""
