"""Pictures in reports: sections and radiographs of runs (``shown`` says which, and what each says), and the set-up.

What they show was kept with the runs (``studies.sections.section``); ``studies.reports.drawing.sections`` draws them.
"""
