#include "server/cli/completion.hpp"

#include <CLI/CLI.hpp>
#include <sstream>
#include <vector>

namespace headframe {
namespace {

struct Word {
  std::string text, what;
  bool takes_value = false;
};

/// Where a command line may stand: after " survey set", say; after nothing at first.
struct Place {
  std::string after;
  std::vector<Word> words;
};

/// Every place, from `app` on.
void add_places(const CLI::App& app, const std::string& after, std::vector<Place>& places) {
  std::vector<Word> words;
  const auto subcommands = app.get_subcommands([](const CLI::App*) { return true; });
  words.reserve(subcommands.size());
  for (const CLI::App* sub : subcommands) words.push_back({sub->get_name(), sub->get_description()});
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames())
      words.push_back({"--" + name, option->get_description(), option->get_items_expected_max() > 0});
  places.push_back({after, std::move(words)});
  for (const CLI::App* sub : subcommands) add_places(*sub, after + " " + sub->get_name(), places);
}

/// As one word of any of the shells.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out.append(c == '\'' ? "'\\''" : std::string(1, c));
  return out + "'";
}

/// How bash and zsh find the place: `set_words` writes what sets the words there.
template <class SetWords>
void write_walk(std::ostream& out, const std::vector<Place>& places, const char* words_before, SetWords set_words) {
  out << "  local word at=''\n  ";
  set_words(places.front());
  out << "\n  for word in " << words_before << "; do\n    case \"$at $word\" in\n";
  for (std::size_t i = 1; i < places.size(); ++i) {
    out << "      " << quoted(places[i].after) << ") ";
    set_words(places[i]);
    out << " ;;\n";
  }
  out << "      *) continue ;;\n    esac\n    at=\"$at $word\"\n  done\n";
}

void write_bash(std::ostream& out, const std::vector<Place>& places) {
  out << "_headframe() {\n";
  write_walk(out, places, "\"${COMP_WORDS[@]:1:COMP_CWORD-1}\"", [&](const Place& place) {
    out << "local words='";
    for (const Word& word : place.words) out << word.text << ' ';
    out << "'";
  });
  out << "  COMPREPLY=($(compgen -W \"$words\" -- \"${COMP_WORDS[COMP_CWORD]}\"))\n}\n"
         "complete -o default -F _headframe headframe\n";
}

void write_zsh(std::ostream& out, const std::vector<Place>& places) {
  out << "_headframe() {\n  local -a found\n";
  write_walk(out, places, "\"${(@)words[2,CURRENT-1]}\"", [&](const Place& place) {
    out << "found=(";
    for (const Word& word : place.words) out << quoted(word.text + ":" + word.what) << ' ';
    out << ")";
  });
  out << "  _describe word found || _files\n}\ncompdef _headframe headframe\n";
}

void write_fish(std::ostream& out, const std::vector<Place>& places) {
  out << "function __headframe_after\n  set -l at ''\n  for word in (commandline -opc)[2..-1]\n"
         "    contains -- \"$at $word\"";
  for (std::size_t i = 1; i < places.size(); ++i) out << ' ' << quoted(places[i].after);
  out << "; and set at \"$at $word\"\n  end\n  test \"$at\" = \"$argv[1]\"\nend\n";
  for (const Place& place : places)
    for (const Word& word : place.words) {
      const bool option = word.text.front() == '-';
      out << "complete -c headframe -n " << quoted("__headframe_after \"" + place.after + "\"")
          << (option ? " -l " : " -a ") << quoted(option ? word.text.substr(2) : word.text)
          << (word.takes_value ? " -r" : "") << " -d " << quoted(word.what) << '\n';
    }
}

}  // namespace

std::string completion(const CLI::App& app, const std::string& shell) {
  std::vector<Place> places;
  add_places(app, "", places);
  std::ostringstream out;
  shell == "zsh" ? write_zsh(out, places) : shell == "fish" ? write_fish(out, places) : write_bash(out, places);
  return out.str();
}

}  // namespace headframe
