"""What holes, craters, debris and plugs of an impact share: its view, edges of matter, and openings by sectors."""
