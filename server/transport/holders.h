// SPDX-License-Identifier: GPL-3.0-or-later
// Who holds which needle or guide. Only a client that holds one may command it; of a scene that does not share them one
// client at a time holds it. Clients are told apart by their routing frames.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace acus {

class Holders {
 public:
  using Client = std::string;

  Holders(int bodies, bool shared) : shared_(shared), holders_(static_cast<std::size_t>(bodies)) {}

  bool holds(const Client& client, int body) const { return of(body).contains(client); }
  bool held(int body) const { return !of(body).empty(); }
  std::vector<int> held_by(const Client& client) const {
    std::vector<int> bodies;
    for (int body = 0; body < count(); ++body)
      if (holds(client, body)) bodies.push_back(body);
    return bodies;
  }
  // Number of the newest command of a holder to the body; 0 before the first.
  std::uint64_t& newest_seq(const Client& client, int body) { return of(body).at(client); }

  // Whether the client may hold the body beside those who do.
  bool free_for(const Client& client, int body) const { return shared_ || !held(body) || holds(client, body); }
  void acquire(const Client& client, int body) { of(body).try_emplace(client, 0); }
  void release(const Client& client, int body) { of(body).erase(client); }
  void release_all(const Client& client) {
    for (auto& clients : holders_) clients.erase(client);
  }

  // A client that holds nothing leaves the world alone while others hold something.
  bool may_change_world(const Client& client) const {
    return !held_by(client).empty() ||
           std::all_of(holders_.begin(), holders_.end(), [](const auto& clients) { return clients.empty(); });
  }

 private:
  using Clients = std::map<Client, std::uint64_t>;

  int count() const { return static_cast<int>(holders_.size()); }
  Clients& of(int body) { return holders_.at(static_cast<std::size_t>(body)); }
  const Clients& of(int body) const { return holders_.at(static_cast<std::size_t>(body)); }

  bool shared_;
  std::vector<Clients> holders_;  // per body
};

}  // namespace acus
