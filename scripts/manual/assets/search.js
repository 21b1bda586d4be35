"use strict";
// PLACES: [page, heading, address, text, words] of every page, of every section, and of every row that names something.
// words: what people call the subject of a page, separated by "|".
const LEFT_OUT = new Set(["a", "an", "and", "or", "the", "of", "in", "to", "is", "what", "how", "for"]);
const SHOWN = 40;

const folded = (text) => text.toLowerCase().replaceAll("ß", "ss").normalize("NFKD").replace(/[\u0300-\u036f]/g, "");
const plain = (text) => folded(text).replaceAll("-", " ");
const escaped = (word) => word.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");

function wordsOf(query) {
  const all = folded(query).split(/[\s"“”]+/).filter(Boolean);
  const telling = all.filter((word) => !LEFT_OUT.has(word));
  return telling.length ? telling : all;
}

// How well a page's words name what is searched: as typed, as the beginning of what is being typed, as the end of a German compound.
function named(names, word) {
  const sought = plain(word);
  if (names.includes(sought)) return 60;
  if (sought.length >= 4 && names.some((name) => name.startsWith(sought))) return 12;
  return names.some((name) => name.length >= 5 && sought.endsWith(name)) ? 12 : 0;
}

// A word counts where it begins a word: most in a heading, less in a page's title, least in the text, where more of it adds little.
function scored(place, words, phrase) {
  const [page, heading, , text] = place.folded;
  let score = 0;
  let met = 0;
  for (const word of words) {
    const begins = new RegExp(`(?<![\\p{L}\\p{N}])${escaped(word)}`, "gu");
    const inText = (text.match(begins) || []).length;
    const value =
      8 * begins.test(heading) +
      3 * page.includes(word) +
      Math.log2(1 + inText) +
      (heading === word ? 20 : 0) +
      named(place.names, word);
    if (value > 0) met += 1;
    score += value;
  }
  if (words.length > 1 && `${heading} ${text}`.includes(phrase)) score += 12;
  if (words.length > 1 && place.names.includes(plain(phrase))) [met, score] = [words.length, score + 100];
  return { place, met, score };
}

// Places from the best on: those that have the most of the words.
function ranked(query, words) {
  const found = words.length ? PLACES.map((place) => scored(place, words, folded(query).trim())) : [];
  const most = Math.max(0, ...found.map((one) => one.met));
  return found.filter((one) => one.met && one.met === most).sort((one, other) => other.score - one.score);
}

function excerpt(text, words) {
  const begins = new RegExp(`(?<![\\p{L}\\p{N}])(${words.map(escaped).join("|")})`, "giu");
  const first = Math.max(0, text.search(begins));
  const from = first < 80 ? 0 : text.indexOf(" ", first - 80) + 1;
  const until = from + 240 < text.length ? text.lastIndexOf(" ", from + 240) : text.length;
  const shown = text.slice(from, until > from ? until : from + 240);
  const line = document.createElement("p");
  let at = 0;
  for (const match of shown.matchAll(begins)) {
    const mark = document.createElement("mark");
    mark.textContent = match[0];
    line.append(shown.slice(at, match.index), mark);
    at = match.index + match[0].length;
  }
  line.prepend(from ? "… " : "");
  line.append(shown.slice(at), until < text.length ? " …" : "");
  return line;
}

function item({ place }, words, phrase) {
  const [page, heading, address, text, names = ""] = place;
  const sought = [...words, phrase];
  const met = names.split("|").filter((name) => sought.some((word) => named([plain(name)], word)));
  const entry = document.createElement("li");
  const link = document.createElement("a");
  link.href = address;
  link.textContent = heading;
  const where = document.createElement("div");
  where.className = "where";
  where.textContent = page;
  entry.append(link, where, excerpt([text, met.join(", ")].filter(Boolean).join(" – "), words));
  return entry;
}

function show(query) {
  const words = wordsOf(query);
  const best = ranked(query, words);
  const most = best.length ? best[0].met : 0;
  const shown = best.slice(0, SHOWN);
  const less = most && most < words.length ? " No place has all of these words." : "";
  const count = best.length > SHOWN ? `The best ${SHOWN} of ${best.length} places.` : `${best.length} ${best.length === 1 ? "place" : "places"}.`;
  document.getElementById("count").textContent = words.length ? count + less : "Type a word, a code or a key.";
  document.getElementById("found").replaceChildren(...shown.map((one) => item(one, words, query.trim())));
}

for (const place of PLACES) {
  place.folded = place.map(folded);
  place.names = plain(place[4] || "").split("|");
}
const input = document.querySelector("header input");
input.value = new URLSearchParams(location.search).get("q") || "";
input.addEventListener("input", () => {
  history.replaceState(null, "", `?q=${encodeURIComponent(input.value)}`);
  show(input.value);
});
show(input.value);
