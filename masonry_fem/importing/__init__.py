"""Files from elsewhere: read, repaired, named. gmsh and meshio are loaded only where a file asks for them."""
