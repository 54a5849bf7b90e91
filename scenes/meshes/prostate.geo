// SPDX-License-Identifier: GPL-3.0-or-later
// A prostate with a target in a block of soft tissue, for brachytherapy.yaml. Millimetres.
// gmsh -3 -format msh22 -o prostate.msh prostate.geo
SetFactory("OpenCASCADE");
Box(1) = {-40, -35, -45, 80, 70, 85};
Sphere(2) = {0, 0, 0, 20};
Dilate {{0, 0, 0}, {1.1, 0.85, 0.95}} { Volume{2}; }
Sphere(3) = {6, 2, -3, 5};
BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Volume{3}; Delete; }
Physical Volume("target") = {3};
Physical Volume("prostate") = {5};
Physical Volume("tissue") = {4};
Field[1] = Ball;
Field[1].XCenter = 0; Field[1].YCenter = 0; Field[1].ZCenter = 0;
Field[1].Radius = 22; Field[1].VIn = 7.5; Field[1].VOut = 13; Field[1].Thickness = 20;
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.Algorithm3D = 1;
Mesh.Optimize = 1;
