"""Units of handbooks: equations in cm, g/cm3 and km/s take SI through these."""

CENTIMETRE = 1e-2  # m
GRAM_PER_CUBIC_CENTIMETRE = 1e3  # kg/m3
KILOMETRE_PER_SECOND = 1e3  # m/s
KSI = 1e3 * 6894.757  # Pa; 1 MPa is 0.145038 ksi
BRINELL = 9.81e6  # Pa: a Brinell number is in kgf/mm2
# Christiansen et al. (2009), Handbook for Designing MMOD Protection, NASA/TM-2009-214785.
HANDBOOK = "NASA/TM-2009-214785"
RYAN = "Ryan and Christiansen (2011), Acta Astronautica 69"
COUR_PALAIS = "Cour-Palais (1987), Int. J. Impact Eng. 5"
