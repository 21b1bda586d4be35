"use strict";
// PLACES: [page, heading, address, text, words] of every page, of every section, and of every row that names something.
// words: what people call the subject of a page, separated by "|".
const LEFT_OUT = new Set(
  ("a an and or the of in to is are it be do does i my me on at by with from for as if can what how when where which why into " +
    "der die das den dem des ein eine einen einer und oder im am mit von vom für fur auf zu zum zur wie was ist sind wo man ich nach bei").split(" "),
);
const ENDINGS = ["ungen", "ings", "ions", "ung", "ing", "ion", "ern", "ed", "en", "er", "es", "em", "e", "n", "s"];
const SHOWN = 40;
// Pages that list names and changes: they have most words, and explain few.
const LISTS = new Set(["http-api.html", "python-reference.html", "changelog.html", "contributing.html", "architecture.html"]);

const folded = (text) => text.toLowerCase().replaceAll("ß", "ss").normalize("NFKD").replace(/[\u0300-\u036f]/g, "");
const escaped = (word) => word.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
const wordsIn = (text) => text.match(/[\p{L}\p{N}]+/gu) || [];

// A word without its endings, English or German, an umlaut as its vowel: Fräser, Fräsern and fraesern are one.
function stem(word) {
  let short = folded(word).replace(/([aou])e/g, "$1");
  const left = (ending) => short.length - ending.length - ending.startsWith("ion");
  for (let next; (next = ENDINGS.find((ending) => short.endsWith(ending) && left(ending) >= 4 && !(ending === "s" && short.endsWith("ss")))); ) short = short.slice(0, -next.length);
  return short;
}

const joined = (text) => stem(wordsIn(folded(text)).join(""));

function wordsOf(query) {
  const all = folded(query).split(/[\s"“”,;?!]+/).filter(Boolean);
  const telling = all.filter((word) => !LEFT_OUT.has(word));
  return telling.length ? telling : all;
}

// Insertions, losses, changes and swaps of neighbours from one word to the other, up to the most.
function distance(one, other, most) {
  if (Math.abs(one.length - other.length) > most) return Infinity;
  let before = [];
  let last = Array.from({ length: other.length + 1 }, (_, at) => at);
  for (let i = 1; i <= one.length; i += 1) {
    const row = [i];
    for (let j = 1; j <= other.length; j += 1) {
      const same = one[i - 1] === other[j - 1];
      row[j] = Math.min(last[j] + 1, row[j - 1] + 1, last[j - 1] + !same);
      if (i > 1 && j > 1 && one[i - 1] === other[j - 2] && one[i - 2] === other[j - 1]) row[j] = Math.min(row[j], before[j - 2] + 1);
    }
    if (Math.min(...row) > most) return Infinity;
    [before, last] = [last, row];
  }
  return last[other.length] > most ? Infinity : last[other.length];
}

// The word as typed where the manual has it, or its beginning; else the nearest word that it has.
function spelt(word) {
  const plain = folded(word);
  if (plain.length < 4 || !/^\p{L}+$/u.test(plain) || BEGINNINGS.has(plain) || STEMS.has(stem(word))) return word;
  const most = plain.length >= 8 ? 2 : 1;
  const short = stem(word);
  const letters = (text) => [...text].sort().join("");
  let [best, least] = [word, most + 0.5];
  for (const [known, [weight, stems]] of VOCABULARY) {
    if (plain.length === 4 && letters(known) !== letters(plain)) continue;
    const changes = Math.min(distance(plain, known, most), short.length >= 6 ? distance(short, stems, 1) : Infinity);
    const away = changes + (known[0] === plain[0] ? 0 : 0.4) - weight;
    if (changes <= most && away < least) [best, least] = [known, away];
  }
  return best;
}

// How well a page's words name what is searched: as typed, as the beginning of what is being typed, as a part of a German compound.
function named(names, word) {
  const sought = joined(word);
  let best = 0;
  for (const { plain, whole, parts } of names) {
    if (plain === word) return 70;
    if (whole === sought) best = 60;
    const share = Math.min(whole.length, sought.length) / Math.max(whole.length, sought.length);
    if (sought.length >= 4 && whole.startsWith(sought)) best = Math.max(best, 12 + 20 * share);
    else if (whole.length >= 4 && sought.endsWith(whole)) best = Math.max(best, 14 + 24 * share);
    else if (whole.length >= 4 && sought.startsWith(whole)) best = Math.max(best, 10 + 20 * share);
    else if (parts.includes(sought)) best = Math.max(best, 8);
  }
  return best;
}

// A word counts where it begins a word: most in a heading, less in a page's title, least in the text, where more of it adds little.
// A page has the words of all its sections, so that its own words decide where a query has several.
function scored(place, words, typed) {
  const [page, heading, , text] = place.folded;
  const lists = LISTS.has(place[2].split("#")[0]);
  let score = 0;
  let met = 0;
  for (const word of words) {
    const begins = new RegExp(`(?<![\\p{L}\\p{N}])${escaped(word)}`, "gu");
    const inText = (text.match(begins) || []).length;
    const written = 8 * (heading.search(begins) >= 0) + 3 * page.includes(word) + Math.log2(1 + inText) + 20 * (heading === word);
    const value = written * (lists ? 0.5 : 1) + named(place.names, word);
    if (value > 0 || (place.whole && place.whole.search(begins) >= 0)) met += 1;
    score += value;
  }
  if (words.length > 1) {
    const stems = words.flatMap(wordsIn).map(stem);
    if (`${heading} ${text}`.includes(words.join(" "))) score += 12;
    const several = place.names.filter(({ parts }) => parts.length > 1 && parts.every((part) => stems.includes(part)));
    score += 30 * Math.max(0, ...several.map(({ parts }) => parts.length));
  }
  const phrases = [joined(typed), joined(words.join(""))];
  if (/\s/.test(typed) && place.names.some(({ whole }) => phrases.includes(whole))) [met, score] = [words.length, score + 100];
  return { place, met, score };
}

// Places from the best on: those that have the most of the words.
function ranked(words, typed) {
  const found = words.length ? PLACES.map((place) => scored(place, words, typed)) : [];
  const most = Math.max(0, ...found.map((one) => one.met));
  return found.filter((one) => one.met && one.met === most && one.score > 0).sort((one, other) => other.score - one.score);
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

function item({ place }, words) {
  const [page, heading, address, text] = place;
  const sought = [...words, words.join("")];
  const met = place.names.filter((name) => sought.some((word) => named([name], word) >= 12)).map((name) => name.text);
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
  const typed = wordsOf(query);
  const words = typed.map(spelt);
  const best = ranked(words, query.trim());
  const most = best.length ? best[0].met : 0;
  const shown = best.slice(0, SHOWN);
  const less = most && most < words.length ? " No place has all of these words." : "";
  const changed = words.join(" ") === typed.join(" ") ? "" : ` Searched: ${words.join(" ")}.`;
  const count = best.length > SHOWN ? `The best ${SHOWN} of ${best.length} places.` : `${best.length} ${best.length === 1 ? "place" : "places"}.`;
  document.getElementById("count").textContent = words.length ? count + less + changed : "Type a word, a code or a key.";
  document.getElementById("found").replaceChildren(...shown.map((one) => item(one, words)));
}

// Every word of the manual: how much it is preferred to others as the meaning of a misspelt one, and its stem.
const VOCABULARY = new Map();
for (const place of PLACES) {
  place.folded = place.slice(0, 4).map(folded);
  const texts = (place[4] || "").split("|").filter(Boolean);
  place.names = texts.map((text) => ({ text, plain: folded(text), whole: joined(text), parts: wordsIn(text).map(stem) }));
  for (const word of wordsIn(place.folded.join(" "))) if (!VOCABULARY.has(word)) VOCABULARY.set(word, [0, stem(word)]);
}
for (const place of PLACES.filter((one) => one[4])) {
  place.whole = PLACES.filter((one) => one[2].split("#")[0] === place[2]).map((one) => one.folded[3]).join(" ");
  for (const { text } of place.names) for (const word of [...wordsIn(folded(text)), wordsIn(folded(text)).join("")]) VOCABULARY.set(word, [0.5, stem(word)]);
}
const STEMS = new Set([...VOCABULARY.keys()].map(stem));
const BEGINNINGS = new Set([...VOCABULARY.keys()].flatMap((word) => Array.from(word, (_, at) => word.slice(0, at + 1))));
const input = document.querySelector("header input");
input.value = new URLSearchParams(location.search).get("q") || "";
input.addEventListener("input", () => {
  history.replaceState(null, "", `?q=${encodeURIComponent(input.value)}`);
  show(input.value);
});
show(input.value);
