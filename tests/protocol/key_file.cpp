// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/key_file.h"

#include <doctest/doctest.h>
#include <sys/stat.h>

#include "tests/support/temporary_folder.h"

namespace acus::protocol::testing {
namespace {

// Of no use but here: two pairs of libzmq's own tests, without the second one's secret. kMarks has characters that
// comments and quotes could be mistaken for.
const std::string kFirst = "Yne@$w-vo<fVvi]a<NY6T1ed:M$fCG*[IaLV{hID";
const std::string kSecret = "D:)Q[IlAW!ahhC2ac:9*A}h:p?([4%wOTJ%JR%cs";
const std::string kSecond = "rq:rM>}U?@Lns47E1%kR.o@n%FcmmsL/@{H8]yf7";
const std::string kMarks = "=####=====....::::aaaaabbbbbcccccddddd00";
const std::string kNoBytes = "#####eeeeefffffggggghhhhhiiiiijjjjjkkkkk";  // its first five are more than 2^32

std::string public_line(const std::string& key) { return "curve\n    public-key = \"" + key + "\"\n"; }
std::string secret_line(const std::string& key) { return "    secret-key = \"" + key + "\"\n"; }
std::string name_line(const std::string& name) { return "metadata\n    name = \"" + name + "\"\n"; }

std::string write(const TemporaryFolder& folder, const std::string& text, mode_t mode = 0600) {
  const std::string path = folder.write("keys", text);
  REQUIRE(chmod(path.c_str(), mode) == 0);
  return path;
}

template <class Read>
std::string error_of(Read read) {
  try {
    read();
  } catch (const KeyError& error) {
    return error.what();
  }
  return {};
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("a pair of keys is read as acus-keygen, pyzmq and czmq write it") {
  const TemporaryFolder folder;
  for (const std::string& text :
       {"# comment\n" + name_line("server") + public_line(kFirst) + secret_line(kSecret),
        "\r\n" + public_line(kFirst) + "\t secret-key='" + kSecret + "' \r\nanything else\n"}) {
    const KeyPair pair = read_key_pair(write(folder, text));
    CHECK(pair.public_key == kFirst);
    CHECK(pair.secret_key == kSecret);
  }
}

TEST_CASE("public keys are those of files one after the other, each with its name") {
  const TemporaryFolder folder;
  const std::string path =
      write(folder, name_line("alice") + public_line(kMarks) + "# and\n" + public_line(kSecond), 0644);
  const std::vector<PublicKey> keys = read_public_keys(path);
  REQUIRE(keys.size() == 2);
  CHECK(keys[0].name == "alice");
  CHECK(keys[0].key == kMarks);
  CHECK(keys[1].name.empty());
  CHECK(keys[1].key == kSecond);
  CHECK(contains(error_of([&] { read_public_key(path); }), "expected one public key, found 2"));
  CHECK(read_public_key(write(folder, public_line(kSecond))).key == kSecond);
}

TEST_CASE("what is wrong with a key file is said without its secret") {
  const TemporaryFolder folder;
  const std::string pair = public_line(kFirst) + secret_line(kSecret);
  const auto problem_with_pair = [&](const std::string& text, mode_t mode = 0600) {
    const std::string path = write(folder, text, mode);
    return error_of([&] { read_key_pair(path); });
  };
  const auto problem_with_list = [&](const std::string& text) {
    const std::string path = write(folder, text, 0644);
    return error_of([&] { read_public_keys(path); });
  };
  CHECK(contains(error_of([&] { read_key_pair(folder / "missing"); }), "cannot be read"));
  for (const mode_t open_to_others : {0604, 0602, 0620, 0644}) {
    CHECK(contains(problem_with_pair(pair, open_to_others), "chmod 600"));
  }
  CHECK(contains(error_of([&] { read_public_keys(write(folder, public_line(kFirst), 0666)); }), "chmod o-w"));
  CHECK(error_of([&] { read_public_keys(write(folder, public_line(kFirst), 0664)); }).empty());
  REQUIRE(mkfifo((folder / "pipe").c_str(), 0600) == 0);
  for (const std::string& endless : {std::string("/dev/zero"), folder / "pipe", folder / "."})
    CHECK(contains(error_of([&] { read_key_pair(endless); }), "is no file"));
  const std::string large = folder.write("large", std::string((1 << 20) + 1, '#'));
  CHECK(contains(error_of([&] { read_public_keys(large); }), "more than 1 MiB"));
  for (const mode_t closed : {0640, 0400, 0440})  // the last two are what systemd makes of LoadCredential=
    CHECK(problem_with_pair(pair, closed).empty());
  CHECK(contains(problem_with_pair(public_line(kFirst)), "found 1 and 0"));
  CHECK(contains(problem_with_pair(pair + pair), "found 2 and 2"));
  CHECK(contains(problem_with_list(""), "no public key"));
  CHECK(contains(problem_with_list(pair), "holds a secret key"));
  for (const std::string& bad : {kSecret.substr(1), kSecret + "0", "\\" + kSecret.substr(1), kNoBytes}) {
    const std::string said = problem_with_pair(public_line(kFirst) + secret_line(bad));
    CHECK(contains(said, "line 3: expected a secret-key of 40 characters"));
    CHECK_FALSE(contains(said, bad));
  }
  for (const std::string& bad : {std::string("short"), kNoBytes})
    CHECK(contains(problem_with_list(public_line(bad)), "line 2: expected a public-key of 40 characters"));
  const std::string strange = problem_with_pair(public_line(kSecond) + secret_line(kSecret));
  CHECK(contains(strange, "the key file '" + (folder / "keys") + "': the public key is not that of the secret key"));
  CHECK_FALSE(contains(strange, kSecret));
}

}  // namespace acus::protocol::testing
