"""Endpoints that tell publish, subscribe and relay elements apart: topics, sets of partitions, sets of
data tags. Each is a bit mask of the elements whose condition it meets, with an example."""

from expressions import combinations, literal

DEFAULT_PARTITION = (literal(""),)
UNLISTED_TAG = ("?", "?")


def _closed(start, singles, allow, deny):
    """All sets: an allow element must take every member of a set, a deny element one (10.4.1.5.3.4)."""
    found, todo = dict(start), list(start.items())
    for mask, name in singles.items():
        if mask not in found:
            found[mask] = [name]
            todo.append((mask, [name]))
    while todo:
        mask, names = todo.pop()
        for single, name in singles.items():
            both = mask & single & allow | (mask | single) & deny
            if both not in found:
                found[both] = names + [name]
                todo.append((both, found[both]))
    return found


class Elements:
    """The elements of both documents for one action, in order; the old document's first."""

    def __init__(self, rules):
        """rules: [(allow, tuple of Criteria)] of both documents."""
        self.criteria = [(allow, one) for allow, several in rules for one in several]
        self.allow = sum(1 << i for i, (allow, _) in enumerate(self.criteria) if allow)
        self.deny = (1 << len(self.criteria)) - 1 & ~self.allow

    def _masks_of_names(self, lists, always):
        """{mask of the elements of whose list an item matches: a name}; `always`: no list is needed."""
        items = tuple({item: None for one in lists if one is not None for item in one})
        place = {item: 1 << i for i, item in enumerate(items)}
        wanted = [(1 << i, sum({place[item] for item in one})) for i, one in enumerate(lists)
                  if one is not None]
        out = {}
        for matched, name in combinations(items):
            out.setdefault(always | sum(bit for bit, mask in wanted if mask & matched), name)
        return out

    def topics(self):
        return self._masks_of_names([one.topics for _, one in self.criteria], 0)

    def partitions(self):
        lists = [DEFAULT_PARTITION if one.partitions is None and allow else one.partitions
                 for allow, one in self.criteria]
        always = sum(1 << i for i, one in enumerate(lists) if one is None)
        return _closed({}, self._masks_of_names(lists, always), self.allow, self.deny)

    def data_tags(self):
        always = sum(1 << i for i, (allow, one) in enumerate(self.criteria)
                     if one.data_tags is None and not allow)
        listed = {tag: None for _, one in self.criteria for tag in one.data_tags or ()}
        singles = {}
        for tag in [*listed, UNLISTED_TAG]:
            mask = sum(1 << i for i, (_, one) in enumerate(self.criteria) if tag in (one.data_tags or ()))
            singles.setdefault(mask | always, tag)
        return _closed({self.allow | always: []}, singles, self.allow, self.deny)

    def endpoints(self):
        """[(mask of the elements that fit, topic, partitions, data tags)], each mask once."""
        found = {}
        partitions, data_tags = self.partitions(), self.data_tags()
        for fits, topic in self.topics().items():
            for in_partition, names in partitions.items():
                for tagged, tags in data_tags.items():
                    found.setdefault(fits & in_partition & tagged, (topic, names, tags))
        return [(mask, *endpoint) for mask, endpoint in found.items()]
