// Keystone arch on two piers: seven irregular voussoirs, dimensions in metres.
//
//   gmsh -3 -format msh41 keystone_arch.geo
//
// x across the opening, y along the depth, z up; z = 0 at the springings. Every block is a volume of
// its own (nothing is shared) and a physical group; the upper face of the keystone is named as well.

depth = 0.40;      // of arch and piers
inner = 1.00;      // radius of the intrados' corners
outer = 1.30;      // radius of the extrados' corners
key_outer = 1.45;  // the keystone rises above its neighbours
count = 7;
key = 4;
// opening angle of each voussoir [degrees], left to right; they add up to 180
angle[] = {28, 24, 30, 16, 27, 26, 29};

pier_inner = 0.95;   // faces of the piers, from the axis
pier_outer = 1.50;
pier_course = 0.60;  // height of each of two courses
footing = 0.30;      // height, and how far it is wider than the pier on both sides

radial = 4;      // elements through the arch's thickness
tangential = 4;  // along a voussoir
through = 3;     // along the depth

// Box-like block: four corners counter-clockwise in the x-z plane, n by m elements, drawn out along y.
Macro Stone
  p = newp;
  Point(p) = {xs[0], 0, zs[0]};
  Point(p + 1) = {xs[1], 0, zs[1]};
  Point(p + 2) = {xs[2], 0, zs[2]};
  Point(p + 3) = {xs[3], 0, zs[3]};
  l = newl;
  Line(l) = {p, p + 1};
  Line(l + 1) = {p + 1, p + 2};
  Line(l + 2) = {p + 2, p + 3};
  Line(l + 3) = {p + 3, p};
  Transfinite Curve {l, l + 2} = n + 1;
  Transfinite Curve {l + 1, l + 3} = m + 1;
  c = newll;
  Curve Loop(c) = {l, l + 1, l + 2, l + 3};
  s = news;
  Plane Surface(s) = {c};
  Transfinite Surface {s};
  Recombine Surface {s};
  made[] = Extrude {0, depth, 0} { Surface{s}; Layers{through}; Recombine; };
Return

// voussoirs, from the left springing
turn = 180;
For i In {1 : count}
  a = turn * Pi / 180;
  b = (turn - angle[i - 1]) * Pi / 180;
  r = outer;
  m = radial;
  If (i == key)
    r = key_outer;
    m = radial + 2;
  EndIf
  n = tangential;
  xs[] = {inner * Cos(a), inner * Cos(b), r * Cos(b), r * Cos(a)};
  zs[] = {inner * Sin(a), inner * Sin(b), r * Sin(b), r * Sin(a)};
  Call Stone;
  If (i == key)
    Physical Volume("keystone") = {made[1]};
    Physical Surface("keystone_top") = {made[4]};
  Else
    Physical Volume(Sprintf("voussoir_%g", i)) = {made[1]};
  EndIf
  turn -= angle[i - 1];
EndFor

// two courses and a footing on each side
For side In {0 : 1}
  For course In {1 : 3}
    x1 = pier_inner;
    x2 = pier_outer;
    If (course == 3)
      x1 -= footing;
      x2 += footing;
      bottom = -2 * pier_course - footing;
      top = -2 * pier_course;
    Else
      bottom = -course * pier_course;
      top = bottom + pier_course;
    EndIf
    n = 4;
    m = course == 3 ? 2 : 4;
    If (side == 0)
      xs[] = {-x2, -x1, -x1, -x2};
    Else
      xs[] = {x1, x2, x2, x1};
    EndIf
    zs[] = {bottom, bottom, top, top};
    Call Stone;
    If (course == 3)
      If (side == 0)
        Physical Volume("footing_left") = {made[1]};
      Else
        Physical Volume("footing_right") = {made[1]};
      EndIf
    Else
      If (side == 0)
        Physical Volume(Sprintf("pier_left_%g", course)) = {made[1]};
      Else
        Physical Volume(Sprintf("pier_right_%g", course)) = {made[1]};
      EndIf
    EndIf
  EndFor
EndFor
