"""Results: files, tables and pictures. PyVista and VTK are imported here only."""
