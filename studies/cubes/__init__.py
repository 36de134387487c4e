"""The cube: the results of a sweep as one labelled xarray Dataset and one NetCDF-4 file.

``variables`` declares what a cube may hold, ``layout`` its dimensions, ``columns`` what runs say, ``catalogue`` what
laws and observations add; ``cube`` puts them together. Imported by processes that publish, never by the API.
"""
