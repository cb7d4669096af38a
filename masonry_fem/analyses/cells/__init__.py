"""Cells: a scene with changed keys, what a run of it leaves, and where that is kept.

All searches are made of them: ``source`` reads the scene whose keys they change, ``cell`` is one trial,
``kept`` finds and keeps rows, one file a cell, and ``crew``, ``process`` and ``worker`` compute them.
"""
