"""What is measured on a shield: its wall (``wall``), its bumpers and the debris behind them (``shield``)."""
