"""Random texts of documents: expressions, tags, subjects, times, algorithms."""

from expressions import expression, is_defined, subject_value

LETTERS = "aab1/"
BRACKETS = ["[ab]", "[!a]", "[^ab]", "[a-c]", "[!a-c]", "[[:alpha:]]", "[[:digit:]]", "[![:digit:]]",
            "[[:alpha:]_]", "[^[:alnum:]/]", "[[:space:]x]", "[[:upper:][:digit:]]", "[]a]", "[!]a]", "[a-]",
            "[-a]", "[\\]a]", "[a\\-b]", "[\\\\]", "[[.a.]b]", "[[=b=]]", "[c-a]", "[?*]",
            "[!-/]", "[a-bd-z]", "[[:punct:]]", "[[:xdigit:]]", "[[:print:]]", "[[:cntrl:]]", "[.-9]"]
FRAGMENTS = ["*", "?", "**", "?*", "rt/", "a", "b", "cmd", "\\a", "\\*", "\\?", "\\[", "[a", "[", "]", "é", "-",
             "\\\\", "a b", "&", "<", "!", "\u00ff", "A", "Z9", "_"]
WHOLE = ["*", "*", "*", "?*", "a", "b", "a*", "b*", "*a", "rt/*", "rt/a", "a?", "?", "a\\", "*\\", "a/*", "*b*",
         "**", "ab", "aa", "[!a]*", "[ab]", "rt/[!a]*"]
DATES = ["2025-01-01T00:00:00", "2026-01-01T00:00:00", "2026-06-01T12:00:00", "2027-01-01T00:00:00",
         "2028-01-01T00:00:00", "2030-01-01T00:00:00"]
SAME_DATE = [".000Z", "Z", "+00:00", ""]
OTHER_DATE = ["+02:00", "-05:30", ".5Z", ".25"]
NAMES = ["a", "b", "a/1", "a/b", "x y", "b.1", "A"]
NAME_EXPRESSIONS = ["*", "**", "*?", "a*", "?", "[a]", "[ab]", "a/*", "*/*", "[!a]", "?*", "[a-c]*", "a?1", "[[:alpha:]]",
                    "b"]
ALGORITHMS = {
    "digital_signature": ["RSASSA-PSS-MGF1SHA256+2048+SHA256", "RSASSA-PKCS1-V1_5+2048+SHA256",
                          "ECDSA+P256+SHA256", "ECDSA+P384+SHA384", "com.example.Ed25519"],
    "key_establishment": ["DHE+MODP-2048-256", "ECDHE-CEUM+P256", "ECDHE-CEUM+P384", "com.example.X25519"],
    "symmetric_cipher": ["AES128+GCM", "AES256+GCM", "com.example.ChaCha20"]}
ALGORITHMS["digital_signature_identity_trust_chain"] = ALGORITHMS["digital_signature"]


def _fragment(rng):
    draw = rng.random()
    if draw < 0.45:
        return rng.choice(LETTERS)
    return rng.choice(BRACKETS) if draw < 0.65 else rng.choice(FRAGMENTS)


def random_expression(rng):
    """Not empty, without blanks at its ends, of a meaning that POSIX defines."""
    while True:
        if rng.random() < 0.55:
            return rng.choice(WHOLE)
        text = "".join(_fragment(rng) for _ in range(rng.randint(1, 4))).strip()
        if text and is_defined(expression(text)):
            return text


def random_name(rng):
    """Of a domain tag; literal, so a star is a star."""
    return rng.choice(["", "", "a", "b", "ab", "rt/a", "*", "a*", "é", "[a]"])


def random_subject(rng, is_expression):
    values = NAME_EXPRESSIONS if is_expression else NAMES
    parts = [f"CN={rng.choice(values)}"]
    if rng.random() < 0.6:
        parts.append(f"O={rng.choice(values if rng.random() < 0.3 else ['x'])}")
    if rng.random() < 0.15:
        parts.append(f"CN={rng.choice(values)}")
    if rng.random() < 0.1:
        joint = [parts[0], f"OU={rng.choice(values)}"]
        rng.shuffle(joint)
        parts[0] = "+".join(joint)
    if rng.random() < 0.3:
        parts.reverse()
    return rng.choice([", ", ",", " , "]).join(parts)


def random_date(rng):
    return rng.choice(DATES) + rng.choice(SAME_DATE if rng.random() < 0.8 else OTHER_DATE)


def same_expression(rng, text):
    """The same set of names, mostly written in another way."""
    at = rng.randrange(len(text))
    letter = text[at]
    if letter == "*" and "[" not in text and "\\" not in text:
        return text[:at] + "*" + text[at:]
    if letter.isascii() and letter.isalnum() and "[" not in text and "\\" not in text:
        return text[:at] + rng.choice([f"[{letter}]", f"\\{letter}", f"[{letter}-{letter}]"]) + text[at + 1:]
    return text


def changed_expression(rng, text):
    """Close to `text`: one thing more, less or in another way."""
    for _ in range(10):
        at, draw = rng.randrange(len(text) + 1), rng.random()
        if draw < 0.25:
            changed = text[:at] + _fragment(rng) + text[at:]
        elif draw < 0.45:
            changed = text[:at] + text[at + 1:]
        elif draw < 0.6:
            changed = same_expression(rng, text)
        elif draw < 0.8:
            changed = text[:at] + rng.choice(["?", "*", "[!a]", "b"]) + text[at + 1:]
        else:
            changed = random_expression(rng)
        changed = changed.strip()
        if changed and changed != text and is_defined(expression(changed)):
            return changed
    return random_expression(rng)


def changed_subject(rng, text, is_expression):
    """Another value at one place, or another subject."""
    pairs = text.split(",")
    at = rng.randrange(len(pairs))
    if "+" in pairs[at] or rng.random() < 0.3:
        return random_subject(rng, is_expression)
    kind = pairs[at].split("=", 1)[0]
    pairs[at] = f"{kind}={rng.choice(NAME_EXPRESSIONS if is_expression else NAMES)}"
    return ",".join(pairs)


def subject_is_defined(text):
    return all(is_defined(subject_value(pair.split("=", 1)[1].strip()))
               for rdn in text.split(",") for pair in rdn.split("+"))
