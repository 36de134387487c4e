"""Problems that several cases share, and what is read off their states."""
