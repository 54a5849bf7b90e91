// SPDX-License-Identifier: GPL-3.0-or-later
// A figure that a source gives beside what is measured here. With ACUS_FIGURES=1 in the environment every comparison is
// printed as a line "what | reference | measured | tolerance"; the table of README.md was taken from there.
#pragma once

#include <doctest/doctest.h>

#include <string>

namespace acus {

// Prints the comparison if it is asked for and says whether it holds: |measured - reference| <= tolerance, all of one
// unit.
bool agrees(const std::string& what, double reference, double measured, double tolerance);

// Observed order of convergence of errors on steps that differ by `ratio`.
double observed_order(double coarse_error, double fine_error, double ratio = 2);

}  // namespace acus
