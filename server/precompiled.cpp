// SPDX-License-Identifier: GPL-3.0-or-later
// Carries the precompiled headers that the other sources of the server use.
