// SPDX-License-Identifier: BSD-3-Clause
// Build-time tool: reads .lcm files (one struct each) and writes the table behind MessageLayouts(), or behind another
// function of that kind.
//
//   generate_layouts OUT.cpp HEADER FUNCTION a_t.lcm b_t.lcm ...
//
// HEADER declares FUNCTION in the namespace plslam. The tool knows the part of LCM's language that this folder uses:
// package, struct, primitive and struct members, and arrays with constant or variable extents. Anything else stops
// the build with file and line.
#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

struct Token {
  std::string text;
  int line = 0;
};

struct Member {
  std::string type;
  std::string name;
  std::vector<std::string> extents;
};

constexpr const char* kOwnPackage = "plslam";

struct Struct {
  std::string package;
  std::string name;
  std::vector<Member> members;

  /// Name in the table: "pose_t" in our own package, "std_msgs.Header" in another.
  std::string Title() const { return TitleOf(name); }
  /// Table name of a type used by a member of this struct.
  std::string TitleOf(const std::string& type) const {
    if (package == kOwnPackage || type.find('.') != std::string::npos) return type;
    return package + "." + type;
  }
  /// Part of names of the generated code.
  std::string Identifier() const { return package == kOwnPackage ? name : package + "_" + name; }
};

const std::map<std::string, std::string> kPrimitives = {
    {"boolean", "kBoolean"}, {"byte", "kByte"},   {"int8_t", "kInt8"},   {"int16_t", "kInt16"}, {"int32_t", "kInt32"},
    {"int64_t", "kInt64"},   {"float", "kFloat"}, {"double", "kDouble"}, {"string", "kString"},
};

bool IsWord(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.'; }

/// Words and single punctuation marks, without comments.
std::vector<Token> Tokens(std::istream& in) {
  std::vector<Token> tokens;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    line = line.substr(0, line.find("//"));
    for (size_t i = 0; i < line.size();) {
      size_t end = i;
      while (end < line.size() && IsWord(line[end])) ++end;
      if (end == i) end = i + 1;
      if (std::isspace(static_cast<unsigned char>(line[i])) == 0) tokens.push_back({line.substr(i, end - i), number});
      i = end;
    }
  }
  return tokens;
}

/// Recursive descent over the tokens of one file.
class Parser {
 public:
  Parser(std::string path, std::vector<Token> tokens) : path_(std::move(path)), tokens_(std::move(tokens)) {}

  Struct Parse() {
    Expect("package");
    const std::string package = Take();
    Expect(";");
    Expect("struct");
    Struct result{package, Take(), {}};
    Expect("{");
    while (Peek() != "}") result.members.push_back(ParseMember());
    Expect("}");
    if (next_ != tokens_.size()) Fail("one struct per file");
    if (result.members.empty()) Fail("a struct needs members");
    return result;
  }

 private:
  Member ParseMember() {
    Member member;
    member.type = Take();
    member.name = Take();
    while (Peek() == "[") {
      Expect("[");
      member.extents.push_back(Take());
      Expect("]");
    }
    Expect(";");
    return member;
  }

  std::string Peek() const { return next_ < tokens_.size() ? tokens_[next_].text : ""; }

  std::string Take() {
    if (next_ == tokens_.size()) Fail("unexpected end");
    return tokens_[next_++].text;
  }

  void Expect(const std::string& text) {
    if (Peek() != text) Fail("expected '" + text + "', found '" + Peek() + "'");
    ++next_;
  }

  [[noreturn]] void Fail(const std::string& why) const {
    const int line = tokens_.empty() ? 1 : tokens_[std::min(next_, tokens_.size() - 1)].line;
    throw std::runtime_error(path_ + ":" + std::to_string(line) + ": " + why);
  }

  std::string path_;
  std::vector<Token> tokens_;
  size_t next_ = 0;
};

using Structs = std::map<std::string, Struct>;

/// Rank of a struct in the table, or an error; also refuses types that contain themselves.
int StructIndex(const Structs& structs, const std::string& name, const std::string& user) {
  const auto found = structs.find(name);
  if (found == structs.end()) throw std::runtime_error(user + ": unknown type " + name);
  return static_cast<int>(std::distance(structs.begin(), found));
}

void CheckDepth(const Structs& structs, const std::string& name, int depth) {
  if (depth > 8) throw std::runtime_error(name + ": types nest too deeply, or contain themselves");
  for (const Member& member : structs.at(name).members) {
    if (kPrimitives.contains(member.type)) continue;
    const std::string type = structs.at(name).TitleOf(member.type);
    StructIndex(structs, type, name);
    CheckDepth(structs, type, depth + 1);
  }
}

std::string Extent(const Struct& owner, size_t member, const std::string& extent) {
  if (std::isdigit(static_cast<unsigned char>(extent[0])) != 0) return "{" + extent + ", -1}";
  for (size_t i = 0; i < member; ++i) {
    if (owner.members[i].name != extent) continue;
    if (owner.members[i].type != "int32_t") throw std::runtime_error(owner.name + "." + extent + ": must be int32_t");
    return "{0, " + std::to_string(i) + "}";
  }
  throw std::runtime_error(owner.name + ": no earlier member " + extent);
}

void WriteStruct(std::ostream& out, const Structs& structs, const Struct& s) {
  std::ostringstream rows;
  for (size_t i = 0; i < s.members.size(); ++i) {
    const Member& member = s.members[i];
    const std::string extents = "k_" + s.Identifier() + "_" + member.name;
    if (!member.extents.empty()) {
      out << "constexpr LayoutDimension " << extents << "[] = {";
      for (const std::string& extent : member.extents) out << Extent(s, i, extent) << ", ";
      out << "};\n";
    }
    const auto primitive = kPrimitives.find(member.type);
    const bool is_struct = primitive == kPrimitives.end();
    rows << "    {\"" << member.name << "\", WireType::" << (is_struct ? "kStruct" : primitive->second) << ", "
         << (is_struct ? StructIndex(structs, s.TitleOf(member.type), s.name) : -1) << ", "
         << (member.extents.empty() ? "{}" : extents) << "},\n";
  }
  out << "constexpr LayoutMember k_" << s.Identifier() << "[] = {\n" << rows.str() << "};\n\n";
}

void Write(std::ostream& out, const std::string& header, const std::string& function, const Structs& structs) {
  out << "// Generated from the .lcm files; do not edit.\n#include \"" << header << "\"\n\n";
  for (const auto& [title, s] : structs) out << "#include \"" << s.package << '/' << s.name << ".hpp\"\n";
  out << "\nnamespace plslam {\nnamespace {\n\n";
  for (const auto& [title, s] : structs) WriteStruct(out, structs, s);
  out << "constexpr MessageLayout kLayouts[] = {\n";
  for (const auto& [title, s] : structs) {
    out << "    {\"" << title << "\", &::" << s.package << "::" << s.name << "::getHash, k_" << s.Identifier()
        << ", &" << function << "},\n";
  }
  out << "};\n\n}  // namespace\n\nstd::span<const MessageLayout> " << function << "() { return kLayouts; }\n\n"
      << "}  // namespace plslam\n";
}

Structs Read(const std::vector<std::string>& paths) {
  Structs structs;
  for (const std::string& path : paths) {
    std::ifstream in(path);
    if (!in) throw std::runtime_error(path + ": cannot be read");
    Struct s = Parser(path, Tokens(in)).Parse();
    structs[s.Title()] = s;
  }
  for (const auto& [name, s] : structs) CheckDepth(structs, name, 0);
  return structs;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc < 5) throw std::runtime_error("usage: generate_layouts OUT.cpp HEADER FUNCTION FILE.lcm ...");
    std::ostringstream text;
    Write(text, argv[2], argv[3], Read({argv + 4, argv + argc}));
    std::ofstream out(argv[1]);
    out << text.str();
    out.close();
    if (!out) throw std::runtime_error(std::string(argv[1]) + ": cannot be written");
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}
