"""What placement rules share: the patch that they place points on, its quadrature, what they give back."""
