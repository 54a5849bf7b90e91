// SPDX-License-Identifier: GPL-3.0-or-later
// A block of soft tissue with a round inclusion, for the scenes inclusion_*.yaml. Millimetres.
// gmsh -3 -format msh22 -o inclusion.msh inclusion.geo
SetFactory("OpenCASCADE");
Box(1) = {-40, -30, -50, 80, 60, 90};
Sphere(2) = {0, 0, 0, 14};
BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Delete; }
Physical Volume("tissue") = {3};
Physical Volume("inclusion") = {2};
Field[2] = Ball;
Field[2].XCenter = 0; Field[2].YCenter = 0; Field[2].ZCenter = 0;
Field[2].Radius = 16; Field[2].VIn = 6.5; Field[2].VOut = 13; Field[2].Thickness = 20;
Background Field = 2;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.Algorithm3D = 1;
Mesh.Optimize = 1;
