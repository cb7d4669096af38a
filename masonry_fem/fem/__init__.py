"""Elastic blocks. DOLFINx, UFL, PETSc and MPI are imported here only, when first needed.

    from masonry_fem.fem.groups import elastic_groups
    groups = elastic_groups(assembly, {block: ElasticMaterial(10e9, 0.2, 2400.0) for block in blocks})

``assemble`` makes K and M of all shapes, ``condense`` the compliance (M̂⁻¹)_el, ``elastic`` steps
blocks in time, ``attachment`` shows them to the contact solver, ``stress`` recovers stresses.
"""
