// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/transitions/vertex_order.h"

#include <algorithm>

#include "server/engine/tick/insertion/finding/tip_place.h"

namespace acus {

namespace {

// Distances along the needle (in spacings).
constexpr double kTooNear = 0.1, kTooFar = 1.6;

// Shifts what belongs to the vertices from `from` on by one place, back or forth. `count`: of the vertices before.
template <class Items>
void shift(Items& items, int from, int count, int by) {
  const auto begin = items.begin() + from, end = items.begin() + count;
  if (by < 0)
    std::move(begin + 1, end, begin);
  else
    std::move_backward(begin, end, end + 1);
}

void shift_all(Path& path, Insertion& state, int from, int by) {
  const int count = static_cast<int>(path.vertices.size());
  if (by > 0) path.vertices.resize(path.vertices.size() + 1);
  shift(path.vertices, from, count, by);
  shift(state.vertices, from, count, by);
  if (by < 0) path.vertices.pop_back();
  for (int& exit : path.exits)
    if (exit >= from) exit += by;
  if (state.last_alongside >= from) state.last_alongside += by;
}

// Behind vertex i.
void add_vertex(const TissueView& tissue, Path& path, Insertion& state, int i, const Vector3& place) {
  const MaterialPoint added = reach_to(tissue, path.vertices[i], place).end;
  const VertexState like = state.vertices[i];
  shift_all(path, state, i + 1, 1);
  path.vertices[i + 1] = added;
  state.vertices[i + 1] = like;
  state.vertices[i + 1].contact.along = 0;
  state.vertices[i + 1].contact.across.setZero();
}

}  // namespace

bool is_rim(const Path& path, int vertex) {
  return vertex == 0 || path.air_behind(vertex - 1) || path.air_behind(vertex);
}

void remove_vertex(Path& path, Insertion& state, int vertex) { shift_all(path, state, vertex, -1); }

void keep_order(const Transition& now, Path& path) {
  const TissueView& tissue = now.at.tissue;
  const NeedleView& needle = now.at.needle;
  Insertion& state = now.state;
  const auto& shaft = now.scratch.located.shaft;
  for (std::size_t k = shaft.size(); k-- > 1;) {  // from the tip, so that numbers before it stay
    const int i = shaft[k - 1].vertex, next = shaft[k].vertex;
    if (next != i + 1 || next >= static_cast<int>(path.vertices.size()) || path.air_behind(i)) continue;
    const Vector3 here = tissue.position(path.vertices[i]), there = tissue.position(path.vertices[next]);
    const Vector3 tangent = curve_point(needle.model, needle.shape, shaft[k].s).tangent;
    const double along = tangent.dot(there - here);
    if (along < kTooNear * path.spacing) {
      if (!is_rim(path, next))
        remove_vertex(path, state, next);
      else if (!is_rim(path, i))
        remove_vertex(path, state, i);
    } else if (along > kTooFar * path.spacing && !path.vertices.full()) {
      add_vertex(tissue, path, state, i, (here + there) / 2);
    }
  }
}

}  // namespace acus
